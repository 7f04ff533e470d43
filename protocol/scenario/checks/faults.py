"""What must hold between faults and the fleet: robots exist, and events follow each other sensibly."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from protocol.scenario.checks.sound import Sound
from protocol.scenario.shape import Finding, Steps

_MEMBERS = 50_000  # the scenario is part of several messages
# what a process is -> what may happen to it -> what it is then
EVENTS = {
    "running": {"kill": "killed", "pause": "paused", "restart": "running"},
    "paused": {"kill": "killed", "resume": "running", "restart": "running"},
    "killed": {"restart": "running"},
}


def fault_findings(sound: Sound, ids: Collection[int] | None) -> Iterator[Finding]:
    """Everything that is wrong with `sensing`, `link` and `process`; `ids` is None while one is malformed."""
    yield from _delays(sound)
    if ids is not None:
        yield from _named_robots(sound, ids)
    yield from _partitions(sound)
    yield from _events(sound)


def _delays(sound: Sound) -> Iterator[Finding]:
    places: list[Steps] = [("sensing", i, "delay") for i in range(sound.size("sensing"))]
    for steps in [*places, ("link", "delay")]:
        delay = sound.get(*steps)
        if isinstance(delay, list) and delay[0] > delay[1]:
            yield steps, f"the low end {delay[0]:g} is above the high end {delay[1]:g}"


def _named_robots(sound: Sound, ids: Collection[int]) -> Iterator[Finding]:
    """Robots that are named elsewhere must exist."""
    named: list[Steps] = [("process", i, "robot") for i in range(sound.size("process"))]
    for i in range(sound.size("sensing")):
        named += [("sensing", i, "robots", n) for n in range(sound.size("sensing", i, "robots"))]
    named += [steps for steps, _ in _members(sound)]
    for steps in named:
        robot = sound.get(*steps)
        if robot is not None and robot not in ids:
            yield steps, f"there is no robot {robot}"


def _members(sound: Sound) -> Iterator[tuple[Steps, int]]:
    """Every place in a partition's group, with the index of the partition."""
    for i in range(sound.size("link", "partition")):
        groups: Steps = ("link", "partition", i, "groups")
        for g in range(sound.size(*groups)):
            for n in range(sound.size(*groups, g)):
                yield (*groups, g, n), i


def _partitions(sound: Sound) -> Iterator[Finding]:
    for i in range(sound.size("link", "partition")):
        begin, end = (sound.get("link", "partition", i, key) for key in ("from", "until"))
        if begin is not None and end is not None and end <= begin:
            yield ("link", "partition", i, "until"), f"{end:g} s is not after `from`, {begin:g} s"
    seen: dict[tuple[int, int], Steps] = {}
    members = list(_members(sound))
    if len(members) > _MEMBERS:
        text = f"the groups of all partitions name {len(members)} robots; at most {_MEMBERS} are allowed"
        yield ("link", "partition"), text
    for steps, partition in members:
        robot = sound.get(*steps)
        if robot is not None and seen.setdefault((partition, robot), steps) != steps:
            yield steps, f"robot {robot} is in a group of this partition already"


def _events(sound: Sound) -> Iterator[Finding]:
    """Whoever was killed cannot be paused, and only whoever was paused can be resumed."""
    faults = []
    for i in range(sound.size("process")):
        robot, at, event = (sound.get("process", i, key) for key in ("robot", "at", "event"))
        if None in (robot, at, event):
            return  # what follows what is unknown
        faults.append((at, i, robot, event))
    state: dict[int, str] = {}
    for at, i, robot, event in sorted(faults):
        now = state.get(robot, "running")
        if event not in EVENTS[now]:
            text = f"robot {robot} is {now} at {at:g} s; possible then: {', '.join(EVENTS[now])}"
            yield ("process", i, "event"), text
        else:
            state[robot] = EVENTS[now][event]
