"""What must hold of the workspace and of the things that stand in it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from protocol.geometry import ConvexPolygon, Disk, Shape
from protocol.geometry.defects import defect
from protocol.scenario.checks.sound import Sound
from protocol.scenario.model import DEFAULT_RADIUS
from protocol.scenario.shape import Finding, Steps

_NAMED = 3  # disks that one thing stands on, that are spelled out


@dataclass(frozen=True)
class Placed:
    """Where a robot's disk is or shall be."""

    name: str
    disk: Disk


def room_of(sound: Sound) -> tuple[Shape | None, list[Finding]]:
    """The workspace, None where it is malformed, and what is wrong with it."""
    points, radius = sound.get("workspace", "points"), sound.get("workspace", "radius")
    if _given(sound, "workspace", "points") and _given(sound, "workspace", "radius"):
        return None, [(("workspace",), "is given by `radius` or by `points`, not by both")]
    if not _given(sound, "workspace", "points"):
        radius = sound.get("workspace", "radius", default=DEFAULT_RADIUS)
        return None if radius is None else Disk(0.0, 0.0, radius), []
    return _polygon(points, ("workspace", "points"))


def space_findings(sound: Sound, room: Shape | None, placed: Iterable[Placed]) -> Iterator[Finding]:
    """Things that are no disk and no convex polygon, outside, or on a robot's start or goal."""
    disks = list(placed)
    for index in range(sound.size("things")):
        shape, findings = thing_at(sound, ("things", index), room)
        yield from findings
        if shape is None:
            continue
        depths = [
            (each.name, depth)
            for each in disks
            if (depth := each.disk.radius - shape.distance(each.disk.x, each.disk.y)) >= 0.0
        ]
        if depths:
            texts = [f"overlaps {who} by {by:.3g} m" if by else f"touches {who}" for who, by in depths]
            more = f" and {len(texts) - _NAMED} more" if len(texts) > _NAMED else ""
            yield ("things", index, _where(shape)), ", ".join(texts[:_NAMED]) + more


def shapes_of(sound: Sound) -> Iterator[tuple[int, Shape]]:
    """Things that are well formed, by their place in the file."""
    for index in range(sound.size("things")):
        shape, _ = _thing(sound, ("things", index))
        if shape is not None:
            yield index, shape


def thing_at(sound: Sound, place: Steps, room: Shape | None) -> tuple[Shape | None, list[Finding]]:
    """The thing that is described there, None where it is malformed, and what is wrong with it."""
    shape, findings = _thing(sound, place)
    if shape is not None and room is not None and _outside(shape, room):
        findings = [((*place, _where(shape)), "lies outside of the workspace")]
    return shape, findings


def _where(shape: Shape) -> str:
    """The key that says where it is."""
    return "points" if isinstance(shape, ConvexPolygon) else "center"


def _thing(sound: Sound, place: Steps) -> tuple[Shape | None, list[Finding]]:
    if sound.get(*place, default={}) is None and not sound.size(*place, "points"):
        return None, []
    given = {key for key in ("center", "radius", "points") if _given(sound, *place, key)}
    if given == {"points"}:
        return _polygon(sound.get(*place, "points"), (*place, "points"))
    if given != {"center", "radius"}:
        return None, [
            (place, "must be a disk, with `center` and `radius`, or a convex polygon, with `points`")
        ]
    center, radius = sound.get(*place, "center"), sound.get(*place, "radius")
    return None if center is None or radius is None else Disk(center[0], center[1], radius), []


def _given(sound: Sound, *steps: str | int) -> bool:
    """Whether there is anything at `steps`, malformed or not."""
    return bool(sound.get(*steps, default="") != "")


def _polygon(points: list[tuple[float, float]] | None, place: Steps) -> tuple[Shape | None, list[Finding]]:
    if points is None:
        return None, []
    corners = [(float(x), float(y)) for x, y in points]
    problem = defect(corners)
    return (None, [(place, problem)]) if problem else (ConvexPolygon(corners), [])


def _outside(shape: Shape, room: Shape) -> bool:
    """Whether no point of a thing is inside the workspace."""
    if isinstance(room, Disk):
        return shape.distance(room.x, room.y) >= room.radius
    return any(shape.limit(nx, ny, 0.0) >= offset for nx, ny, offset in room.sides) or (
        isinstance(shape, Disk) and room.distance(shape.x, shape.y) >= shape.radius
    )
