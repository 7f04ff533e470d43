"""Checks of places in a scenario: a workspace, disks in it that do not overlap, obstacles, and parts; and the
largest distance of an external robot from its start.

A check ignores malformed values: such a number is NaN. Contact counts as overlap: phi is 1 there, beta 0.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from math import isfinite
from typing import Final

from protocol.geometry import ConvexPolygon, Disk, Shape
from protocol.region import distance
from protocol.scenario.model import CELLS, MOST_CELLS, Obstacle, Position, Scenario, Workspace
from protocol.scenario.tables import Mistake, Steps

_NAMED = 3  # listed overlaps of one disk
_ROUNDING: Final = 1e-9  # m; a smaller overlap is called a touch
_Named = tuple[str, Shape]  # its name in messages


@dataclass(frozen=True)
class Sound:
    """Which parts of a scenario are valid; `malformed` are the paths that are not."""

    malformed: Collection[Steps]

    def __call__(self, *steps: str | int) -> bool:
        """Whether nothing at this path, above or below it is malformed."""
        return not any(each[: len(steps)] == steps[: len(each)] for each in self.malformed)


def placed(scenario: Scenario, sound: Sound) -> tuple[Shape | None, list[Mistake]]:
    """The workspace, None if it is malformed, and all findings about places."""
    room, findings = _shape(scenario.workspace, ("workspace",), sound)
    robots: dict[str, list[_Named]] = {}
    for end in ("start", "goal"):
        found, robots[end] = _robots(scenario, end)
        findings += found
    obstacles: list[_Named] = []
    for index, each in enumerate(scenario.obstacles):
        steps = ("obstacles", index)
        shape, found = obstacle(each, steps, sound, room)
        findings += found
        if shape is not None:
            findings += _overlaps(shape, robots["start"] + robots["goal"], (*steps, _where(shape)))
            obstacles.append((f"obstacles[{index}]", shape))
    for index, spec in enumerate(scenario.robots):
        findings += fits(room, spec.radius, ("robots", index), start=spec.start, goal=spec.goal)
    if scenario.parts:
        findings += _cells(scenario, room)
        for end, others in robots.items():
            findings += _parts(scenario, end, room, [*obstacles, *others])
    return room, findings


def _shape(found: Workspace | Obstacle, steps: Steps, sound: Sound) -> tuple[Shape | None, list[Mistake]]:
    if not sound(*steps):
        return None, []
    if problem := found.defect():
        is_polygon = found.points is not None and found.radius is None
        return None, [((*steps, "points") if is_polygon else steps, problem)]
    return found.shape, []


def fits(room: Shape | None, radius: float, steps: Steps, **points: Position) -> Iterator[Mistake]:
    """Whether a disk of `radius` is inside the workspace at each of these points."""
    if room is None or not isfinite(radius):
        return
    if isinstance(room, Disk) and radius >= room.radius:
        text = f"a disk of radius {radius:g} m does not fit into the workspace, of radius {room.radius:g} m"
        yield (*steps, "radius"), text
        return
    for key, point in points.items():
        yield from inside(room, point, radius, (*steps, key))


def inside(room: Shape, point: Position, radius: float, steps: Steps) -> Iterator[Mistake]:
    """Whether a disk is inside the workspace at a point."""
    if all(map(isfinite, point)) and (beyond := room.distance(*point) + radius) >= 0.0:
        reaches = f"reaches {beyond:.3g} m out of the workspace"
        yield steps, reaches if beyond > _ROUNDING else "touches the boundary"


def obstacle(
    obstacle: Obstacle, steps: Steps, sound: Sound, room: Shape | None
) -> tuple[Shape | None, list[Mistake]]:
    """The shape of an obstacle, None if it has none, and findings about it."""
    shape, findings = _shape(obstacle, steps, sound)
    if shape is not None and room is not None and lies_outside(shape, room):
        findings = [((*steps, _where(shape)), "lies outside of the workspace")]
    return shape, findings


def lies_outside(shape: Shape, room: Shape) -> bool:
    """Whether no part of an obstacle is inside the workspace."""
    if isinstance(room, Disk):
        return shape.distance(room.x, room.y) >= room.radius
    return any(-shape.support(-nx, -ny) >= offset for nx, ny, offset in room.sides) or (
        isinstance(shape, Disk) and room.distance(shape.x, shape.y) >= shape.radius
    )


def _robots(scenario: Scenario, end: str) -> tuple[list[Mistake], list[_Named]]:
    """Starts or goals of robots, each against those before it in the file."""
    findings: list[Mistake] = []
    before: list[tuple[str, Shape]] = []
    for index, spec in enumerate(scenario.robots):
        disk = Disk(*(spec.start if end == "start" else spec.goal), spec.radius)
        if _is_finite(disk):
            findings += _overlaps(disk, before, ("robots", index, end))
            before.append((f"robot {spec.id}" if spec.id else f"robots[{index}]", disk))
    return findings, [(f"the {end} of {robot}", disk) for robot, disk in before]


def _parts(scenario: Scenario, end: str, room: Shape | None, others: list[_Named]) -> Iterator[Mistake]:
    """Parts against the workspace and `others`, to which each part is added."""
    for index, part in enumerate(scenario.parts):
        disk = Disk(*(part.start if end == "start" else part.goal), part.radius)
        if not _is_finite(disk):
            continue
        steps = ("parts", index, end)
        if room is not None and (beyond := room.distance(disk.x, disk.y) + disk.radius) > 0.0:
            yield steps, f"reaches {beyond:.3g} m out of the workspace"
        yield from _overlaps(disk, others, steps)
        others.append((f"the {end} of part {index + 1}", disk))


def _is_finite(disk: Disk) -> bool:
    return isfinite(disk.x) and isfinite(disk.y) and isfinite(disk.radius)


def _where(shape: Shape) -> str:
    return "points" if isinstance(shape, ConvexPolygon) else "center"


def _overlaps(shape: Shape, others: Iterable[_Named], steps: Steps) -> Iterator[Mistake]:
    """Names of the shapes that a shape overlaps or touches, as one text; of each two one is a disk."""
    around = shape.around
    depths = [
        (name, depth)
        for name, other in others
        if abs(around.x - (near := other.around).x) <= around.radius + near.radius
        and (depth := -distance(other, shape)) >= 0.0
    ]
    texts = [
        f"overlaps {name} by {depth:.3g} m" if depth > _ROUNDING else f"touches {name}"
        for name, depth in depths[:_NAMED]
    ]
    if texts:
        more = f" and {len(depths) - _NAMED} more" if len(depths) > _NAMED else ""
        yield steps, ", ".join(texts) + more


def _cells(scenario: Scenario, room: Shape | None) -> Iterator[Mistake]:
    """Findings about a grid that is too large for planning parts."""
    radii = [each.radius for each in scenario.parts] + [each.radius for each in scenario.robots]
    radii = [radius for radius in radii if isfinite(radius)]
    if room is None or not radii:
        return
    (left, low), (right, high) = room.box
    smallest = min(radii)
    cells = (right - left) * (high - low) / (smallest / CELLS) ** 2
    if cells > MOST_CELLS:
        yield (
            ("workspace",),
            f"is too large to carry disks of {smallest:g} m in: to plan on a grid of {CELLS:g} cells to a "
            f"radius takes {cells:.2g} of them, at most {MOST_CELLS:.0e} fit; use larger disks or less room",
        )


SHARE: Final = 0.99  # share of the gap, more than rounding below 1


def room_at_start(scenario: Scenario, robot: int) -> tuple[float, str]:
    """Largest distance of a robot from its start, m, and the reason for it.

    Half of the gap to another starting disk is the other's; the gap to obstacles and to the boundary is its
    own.
    """
    own = scenario.spec(robot)
    rooms = [(-scenario.workspace.shape.distance(*own.start) - own.radius, "the boundary")]
    for other in scenario.robots:
        if other.id != robot:
            gap = math.dist(own.start, other.start) - own.radius - other.radius
            rooms.append((0.5 * gap, f"robot {other.id}"))
    for number, shape in scenario.shapes.items():
        rooms.append((shape.distance(*own.start) - own.radius, f"obstacle {number}"))
    return min(rooms)
