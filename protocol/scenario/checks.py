"""Checks between the fields of a scenario: ids that exist, times in order, bodies that the plant supports.

Each check reads a whole scenario and ignores malformed fields: such a number is NaN, an id 0, and `Sound`
tells where more has to be known.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator

from protocol.errors import UsageError
from protocol.geometry import Shape
from protocol.scenario.body import (
    BRISKEST,
    FRAMES,
    LONGEST,
    PRESETS,
    SHORTEST,
    TOPICS,
    Base,
    Body,
    Preset,
    ros_name,
    span_of,
)
from protocol.scenario.model import ACTIONS, Order, RobotSpec, Scenario
from protocol.scenario.places import Sound, fits, inside, obstacle, placed
from protocol.scenario.tables import Mistake, Steps, written

_LONGEST = 10**9  # ticks
_LONG_NAME = 200  # characters
_LONG_TEXT = 10_000  # characters
_MEMBERS = 50_000  # of partitions' groups: the scenario is part of several messages
_TICKS = 3  # from a Command to the Tick that acknowledges it, and one late tick
_LARGEST_SPAN = 1e6  # s
# state of a process -> fault -> state afterwards
EVENTS = {
    "running": {"kill": "killed", "pause": "paused", "restart": "running"},
    "paused": {"kill": "killed", "resume": "running", "restart": "running"},
    "killed": {"restart": "running"},
}


def checked(scenario: Scenario, malformed: Collection[Steps]) -> list[Mistake]:
    """All findings between fields; `malformed` lists the fields that are invalid by themselves."""
    sound = Sound(malformed)
    room, findings = placed(scenario, sound)
    findings = [
        *findings,
        *_ids(scenario),
        *_map(scenario),
        *_carriers(scenario, sound),
        *_times(scenario),
        *_texts(scenario),
        *_bodies(scenario, sound),
        *_bases(scenario, sound),
        *_faults(scenario, sound),
        *_orders(scenario, sound, room),
    ]
    return [
        (steps, text) for steps, text in findings if not any(steps[: len(each)] == each for each in malformed)
    ]


def misfits(spec: RobotSpec, default: Preset | Body) -> Iterator[str]:
    """Findings about a robot's own or default body."""
    own = default if spec.body is None else spec.body
    body = PRESETS[own] if isinstance(own, str) else own
    for steps, text in (*_wheels(("body",), body), *_hull(("radius",), body, spec.radius)):
        yield f"{written(steps)}: {text}"


def doubts(scenario: Scenario) -> Iterator[str]:
    """Values of a valid scenario that its author can hardly mean."""
    step, room = scenario.time.step, scenario.workspace.shape.around.radius
    if max(scenario.control.speed * step / room, 2.0 * step / scenario.time.limit) > 1.0:
        yield f"time.step, control.speed: within {step:g} s the run ends, or a robot crosses the workspace"
    if (worst := max((sensing.bound for sensing in scenario.sensing), default=0.0)) > room:
        yield f"sensing: an error of {worst:g} m exceeds the workspace's radius, {room:g} m"


# -- names and times


def _ids(scenario: Scenario) -> Iterator[Mistake]:
    first: dict[int, int] = {}
    for index, spec in enumerate(scenario.robots):
        if spec.id and first.setdefault(spec.id, index) != index:
            yield ("robots", index, "id"), f"robots[{first[spec.id]}] already has the id {spec.id}"


def _times(scenario: Scenario) -> Iterator[Mistake]:
    step, limit = scenario.time.step, scenario.time.limit
    if limit < step:
        yield ("time", "limit"), f"{limit:g} s is less than one step of {step:g} s"
    elif limit > _LONGEST * step:
        yield ("time", "limit"), f"{limit:g} s are more than {_LONGEST:g} steps of {step:g} s"
    for steps, span in _spans(scenario).items():
        if isinstance(span, tuple):
            if span[0] > span[1]:
                yield steps, f"the low end {span[0]:g} is above the high end {span[1]:g}"
        elif span < 0.0:
            yield steps, f"must be at least 0, is {span:g}"
        elif span > _LARGEST_SPAN:
            yield steps, f"must be at most {_LARGEST_SPAN:g}, is {span:g}"
    roaming = scenario.link.roaming
    if roaming is not None and (longest := max(span_of(roaming.gap))) > roaming.every:
        yield ("link", "roaming", "gap"), f"{longest:g} s is longer than `every`, {roaming.every:g} s"


def _spans(scenario: Scenario) -> dict[Steps, float | tuple[float, float]]:
    link = scenario.link
    spans: dict[Steps, float | tuple[float, float]] = {("link", "delay"): link.delay}
    spans |= {("sensing", n, "delay"): sensing.delay for n, sensing in enumerate(scenario.sensing)}
    if link.burst is not None:
        spans["link", "burst", "delay"] = link.burst.delay
    if link.roaming is not None:
        spans["link", "roaming", "gap"] = link.roaming.gap
    return spans


def _texts(scenario: Scenario) -> Iterator[Mistake]:
    name, description = scenario.name, scenario.description
    if not (name.isprintable() and len(name) <= _LONG_NAME):
        yield ("name",), f"must have no control characters, and at most {_LONG_NAME} characters"
    shown = description.replace("\n", "").replace("\t", "")
    if not (shown.isprintable() and len(description) <= _LONG_TEXT):
        text = f"must have no control characters but line ends and tabs, and at most {_LONG_TEXT} characters"
        yield ("description",), text


# -- bodies and bases


def described(scenario: Scenario) -> list[tuple[Steps, RobotSpec]]:
    """Places of robots' descriptions: those at the start, and those that orders add."""
    return [
        *((("robots", index), spec) for index, spec in enumerate(scenario.robots)),
        *(
            (("orders", index, "add"), order.add)
            for index, order in enumerate(scenario.orders)
            if order.add is not None
        ),
    ]


def _body(scenario: Scenario, sound: Sound, steps: Steps, spec: RobotSpec) -> Body | None:
    """The body of a robot described at `steps`; None if it is malformed."""
    if not sound(*steps, "body") or (spec.body is None and not sound("body")):
        return None
    body = scenario.body if spec.body is None else spec.body
    return PRESETS.get(body) if isinstance(body, str) else body


def _bodies(scenario: Scenario, sound: Sound) -> Iterator[Mistake]:
    physics = scenario.world.plant == "mujoco"
    if physics and not SHORTEST <= scenario.time.step <= LONGEST:
        yield (
            ("time", "step"),
            f"must be from {SHORTEST:g} to {LONGEST:g} s in MuJoCo: "
            "with other periods the errors of bodies were not measured",
        )
    if isinstance(scenario.body, Body):
        yield from _wheels(("body",), scenario.body)
    for steps, spec in described(scenario):
        if isinstance(spec.body, Body):
            yield from _wheels((*steps, "body"), spec.body)
        body = _body(scenario, sound, steps, spec)
        if body is None:
            continue
        yield from _hull((*steps, "radius"), body, spec.radius)
        if physics:
            yield from _physical((*steps, "body"), body)


def _map(scenario: Scenario) -> Iterator[Mistake]:
    if scenario.map is not None:
        yield ("map",), "must be a file that can be read: load the scenario from a file, beside its map"


def _carriers(scenario: Scenario, sound: Sound) -> Iterator[Mistake]:
    """Settings that cannot be combined with parts."""
    if not scenario.parts:
        return
    plant = scenario.world.plant
    if plant != "integrator" and sound("world", "plant"):
        yield ("parts",), f'are carried with world.plant = "integrator" only, not with "{plant}"'
    for steps, spec in described(scenario):
        body = _body(scenario, sound, steps, spec)
        if body is not None and body.kind != "point":
            yield (*steps, "body"), 'cannot carry parts: leave parts out, or let every body be a "point"'
    if scenario.network.interest == "near":
        yield (("network", "interest"), "robots that carry parts plan with all others' ways: leave it out")


def _wheels(steps: Steps, body: Body) -> Iterator[Mistake]:
    if body.kind == "differential-drive":
        for key, length in (("offset", body.offset), ("track", body.track)):
            if not length:
                yield (*steps, key), "must be above 0 for a body on two wheels"


def _physical(steps: Steps, body: Body) -> Iterator[Mistake]:
    """The reason why MuJoCo does not support a body."""
    if body.kind != "differential-drive":
        yield steps, 'world.plant = "mujoco" moves robots on two wheels only, such as "turtlebot3-burger"'
    elif body.acceleration > BRISKEST:
        yield (*steps, "acceleration"), f"must be at most {BRISKEST:g} in MuJoCo, or wheels slip"


def _hull(steps: Steps, body: Body, radius: float) -> Iterator[Mistake]:
    if body.disk is not None and radius < body.disk * (1.0 - 1e-9):
        yield steps, f"must be at least {body.disk:g}, for the body lies inside the disk"


def _bases(scenario: Scenario, sound: Sound) -> Iterator[Mistake]:
    """External bases: bodies that brake, distinct keys, no scripted faults."""
    external = scenario.is_external
    if scenario.base is not None:
        yield from _names(("base",), scenario.base)
    keys: dict[str, Steps] = {}
    topics = (
        TOPICS if scenario.control.law == "external" else TOPICS[:-1]
    )  # otherwise there is no desired velocity
    for steps, spec in described(scenario):
        if spec.base is not None:
            yield from _names((*steps, "base"), spec.base)
        base = scenario.base if spec.base is None else spec.base
        if base is None and not external:
            continue
        body = _body(scenario, sound, steps, spec)
        if external and body is not None and body.kind == "point":
            text = 'an external base cannot stop at once: set `body`, for example to "turtlebot3-burger"'
            yield (*steps, "body"), text
        if spec.id and sound("base") and sound(*steps, "base"):
            yield from _shared(steps, (base or Base()).of(spec.id), topics, keys)
    if external:
        yield from _external(scenario)


def _names(steps: Steps, base: Base) -> Iterator[Mistake]:
    """Names that are invalid in keys, and frames that are invalid in headers."""
    for key in ("namespace", *TOPICS):
        name = getattr(base, key)
        try:
            ros_name(name)
        except UsageError as error:
            yield (*steps, key), str(error)
        if key != "namespace" and not name.strip("/"):
            yield (*steps, key), "must not be empty"
    for key in FRAMES:
        if not getattr(base, key).isprintable():
            yield (*steps, key), "must have no control characters"
    if base.delay > base.latency:
        yield (*steps, "delay"), f"must be at most `latency`, {base.latency:g}: the least delay of a message"


def _shared(robot: Steps, base: Base, topics: Iterable[str], seen: dict[str, Steps]) -> Iterator[Mistake]:
    """Keys of two topics, of one robot or of two; `seen` are those of robots before this one."""
    keys: dict[str, str] = {}
    for topic in topics:
        key = base.topic(getattr(base, topic))
        if keys.setdefault(key, topic) != topic:
            text = f"`{keys[key]}` and `{topic}` are both {key}: give each topic a name of its own"
            yield (*robot, "base"), text
        elif key in seen:
            text = f"has the same key {key} as {written(seen[key])}: give it a namespace of its own"
            yield (*robot, "base"), text
            return
    seen.update(dict.fromkeys(keys, robot))


def _external(scenario: Scenario) -> Iterator[Mistake]:
    if scenario.process:
        yield ("process",), "process faults cannot be scripted for a fleet that is not simulated"
    if scenario.network.interest == "near":
        text = "the world has no summary of a fleet that is not simulated: leave it out"
        yield ("network", "interest"), text
    step, lease = scenario.time.step, scenario.world.lease
    if lease < _TICKS * step:
        yield ("world", "lease"), f"must be at least {_TICKS} ticks, {_TICKS * step:g} s, is {lease:g} s"


# -- faults


def _known(scenario: Scenario, sound: Sound) -> set[int] | None:
    """Ids that are present at some time, None while one is malformed."""
    ids = {spec.id for _, spec in described(scenario)}
    hidden: set[Steps] = {("robots",), ("orders",)}
    for n in range(len(scenario.orders)):
        hidden |= {("orders", n), ("orders", n, "add")}
    return None if 0 in ids or not hidden.isdisjoint(sound.malformed) else ids


def _faults(scenario: Scenario, sound: Sound) -> Iterator[Mistake]:
    """Named robots exist, partitions have groups and a time, events follow each other."""
    named: list[tuple[Steps, int]] = [
        (("process", n, "robot"), fault.robot) for n, fault in enumerate(scenario.process)
    ]
    for n, sensing in enumerate(scenario.sensing):
        named += [(("sensing", n, "robots", m), robot) for m, robot in enumerate(sensing.robots or ())]
    members = list(_members(scenario))
    named += [(steps, robot) for steps, _, robot in members]
    ids = _known(scenario, sound)
    for steps, robot in named:
        if ids is not None and robot not in ids:
            yield steps, f"there is no robot {robot}"
    for n, partition in enumerate(scenario.link.partition):
        if partition.until <= partition.from_:
            text = f"{partition.until:g} s is not after `from`, {partition.from_:g} s"
            yield ("link", "partition", n, "until"), text
    if len(members) > _MEMBERS:
        text = f"the groups of all partitions name {len(members)} robots; at most {_MEMBERS} are allowed"
        yield ("link", "partition"), text
    seen: dict[tuple[int, int], Steps] = {}
    for steps, n, robot in members:
        if robot and seen.setdefault((n, robot), steps) != steps:
            yield steps, f"robot {robot} is in a group of this partition already"
    if sound("process"):
        yield from _events(scenario)


def _members(scenario: Scenario) -> Iterator[tuple[Steps, int, int]]:
    for n, partition in enumerate(scenario.link.partition):
        for g, group in enumerate(partition.groups):
            for m, robot in enumerate(group):
                yield ("link", "partition", n, "groups", g, m), n, robot


def _events(scenario: Scenario) -> Iterator[Mistake]:
    """A killed process cannot be paused, and only a paused one can be resumed."""
    state: dict[int, str] = {}
    for n, fault in sorted(enumerate(scenario.process), key=lambda each: (each[1].at, each[0])):
        now = state.get(fault.robot, "running")
        if fault.event not in EVENTS[now]:
            text = f"robot {fault.robot} is {now} at {fault.at:g} s; possible then: {', '.join(EVENTS[now])}"
            yield ("process", n, "event"), text
        else:
            state[fault.robot] = EVENTS[now][fault.event]


# -- orders


def _orders(scenario: Scenario, sound: Sound, room: Shape | None) -> Iterator[Mistake]:
    """Each has one operation, with robots and obstacles that are present at some time."""
    ids = _known(scenario, sound)
    obstacles = len(scenario.obstacles) + sum(order.place is not None for order in scenario.orders)
    for index, order in enumerate(scenario.orders):
        steps: Steps = ("orders", index)
        asked = [a for a in ACTIONS if getattr(order, a) is not None or not sound(*steps, a)]
        if len(asked) != 1:
            how = f"not {' and '.join(asked)}" if asked else "and asks for none"
            yield steps, f"must ask for one of {', '.join(ACTIONS)}, {how}"
            continue
        yield from _asked(order, steps, sound, room)
        for key, robot in (("goal", order.goal and order.goal.robot), ("remove", order.remove)):
            if robot and ids is not None and robot not in ids:
                path = (*steps, key, "robot") if key == "goal" else (*steps, key)
                yield path, f"there is never a robot {robot}"
        if order.take is not None and order.take > obstacles:
            yield (*steps, "take"), f"there is never an obstacle {order.take}"


def _asked(order: Order, steps: Steps, sound: Sound, room: Shape | None) -> Iterator[Mistake]:
    """Points in the workspace, and disks and obstacles inside it."""
    if order.place is not None:
        yield from obstacle(order.place, (*steps, "place"), sound, room)[1]
    if room is not None and order.goal is not None:
        for n, point in enumerate(order.goal.points):
            yield from inside(room, point, 0.0, (*steps, "goal", "points", n))
    if order.add is not None:
        spec = order.add
        yield from fits(room, spec.radius, (*steps, "add"), start=spec.start, goal=spec.goal)
