"""What must hold between the fields of a scenario: disks that do not overlap, ids that exist, times in order.

The checks read the plain document, so that they also speak when other fields are malformed: whatever
touches a malformed field is passed over.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from math import hypot

from protocol.geometry import Disk, Shape
from protocol.scenario.checks.bases import base_findings
from protocol.scenario.checks.bodies import body_findings
from protocol.scenario.checks.faults import fault_findings
from protocol.scenario.checks.orders import named_robots, order_findings
from protocol.scenario.checks.parts import part_findings
from protocol.scenario.checks.sound import Sound
from protocol.scenario.checks.space import Placed, room_of, space_findings
from protocol.scenario.model import Time
from protocol.scenario.shape import Document, Finding, Steps

_NAMED = 3  # overlaps of one disk that are spelled out
_LONGEST = 10**9  # ticks
_LONG_NAME = 200


@dataclass(frozen=True)
class _Disk:
    """What is known of one entry of `robots`; None for what is malformed."""

    index: int
    id: int | None
    radius: float | None
    start: list[float] | None
    goal: list[float] | None

    @property
    def name(self) -> str:
        return f"robots[{self.index}]" if self.id is None else f"robot {self.id}"


def checked(document: Document, malformed: Collection[Steps]) -> list[Finding]:
    """Everything that is wrong between fields; `malformed` names the fields that are wrong in themselves."""
    sound = Sound(document, malformed)
    disks = [
        _Disk(i, *(sound.get("robots", i, key) for key in ("id", "radius", "start", "goal")))
        for i in range(sound.size("robots"))
    ]
    room, findings = room_of(sound)
    ids = {disk.id for disk in disks if disk.id is not None}
    known = ids if all(disk.id is not None for disk in disks) else None
    return [
        *_ids(disks),
        *findings,
        *_fit(disks, room),
        *_overlaps(disks, "start"),
        *_overlaps(disks, "goal"),
        *space_findings(sound, room, _placed(disks)),
        *part_findings(sound, room, _placed(disks)),
        *_times(sound),
        *_texts(sound),
        *body_findings(sound),
        *base_findings(sound),
        *fault_findings(sound, named_robots(sound, known)),
        *order_findings(sound, room, known),
    ]


def _ids(disks: list[_Disk]) -> Iterator[Finding]:
    first: dict[int, int] = {}
    for disk in disks:
        if disk.id is not None and first.setdefault(disk.id, disk.index) != disk.index:
            yield ("robots", disk.index, "id"), f"{disk.id} is the id of robots[{first[disk.id]}] already"


def _fit(disks: list[_Disk], room: Shape | None) -> Iterator[Finding]:
    for disk in disks:
        if room is None or disk.radius is None:
            continue
        if isinstance(room, Disk) and disk.radius >= room.radius:
            text = f"a disk of radius {disk.radius:g} m does not fit into the workspace of {room.radius:g} m"
            yield ("robots", disk.index, "radius"), text
            continue
        for key, point in (("start", disk.start), ("goal", disk.goal)):
            if point is not None and (beyond := room.distance(*point) + disk.radius) >= 0.0:
                text = f"reaches {beyond:.3g} m out of the workspace" if beyond else "touches the boundary"
                yield ("robots", disk.index, key), text


def _placed(disks: list[_Disk]) -> Iterator[Placed]:
    """Every disk where it begins and where it shall be."""
    for disk in disks:
        for key, point in (("start", disk.start), ("goal", disk.goal)):
            if point is not None and disk.radius is not None:
                yield Placed(f"the {key} of {disk.name}", Disk(point[0], point[1], disk.radius))


def _overlaps(disks: list[_Disk], key: str) -> Iterator[Finding]:
    """Each disk against those before it in the file. Contact counts: phi is 1 there, and beta 0."""
    placed: list[tuple[_Disk, float, float, float]] = []
    for disk in disks:
        point = disk.start if key == "start" else disk.goal
        if point is None or disk.radius is None:
            continue
        x, y, radius = point[0], point[1], disk.radius
        depths = [
            (other.name, depth)
            for other, ox, oy, r in placed
            if abs(x - ox) <= (reach := radius + r) and (depth := reach - hypot(x - ox, y - oy)) >= 0.0
        ]
        placed.append((disk, x, y, radius))
        if depths:
            texts = [
                f"overlaps {who} by {by:.3g} m" if by else f"touches {who}" for who, by in depths[:_NAMED]
            ]
            more = f" and {len(depths) - _NAMED} more" if len(depths) > _NAMED else ""
            yield ("robots", disk.index, key), ", ".join(texts) + more


def _texts(sound: Sound) -> Iterator[Finding]:
    """What is printed wherever the run is shown."""
    name, description = sound.get("name", default=""), sound.get("description", default="")
    if name is not None and not (name.isprintable() and len(name) <= _LONG_NAME):
        yield ("name",), f"must have no control characters, and at most {_LONG_NAME} characters"
    if description is not None and not description.replace("\n", "").replace("\t", "").isprintable():
        yield ("description",), "must have no control characters but line ends and tabs"


def _times(sound: Sound) -> Iterator[Finding]:
    step = sound.get("time", "step", default=Time().step)
    limit = sound.get("time", "limit", default=Time().limit)
    if step is None or limit is None:
        return
    if limit < step:
        yield ("time", "limit"), f"{limit:g} s is less than one step of {step:g} s"
    elif limit > _LONGEST * step:
        yield ("time", "limit"), f"{limit:g} s are more than {_LONGEST:g} steps of {step:g} s"
