"""What stands around robots that are drawn already, and what encloses them."""

from __future__ import annotations

import math
from collections.abc import Sequence

from deploy.studies.falsify.scenarios.dice import Dice
from protocol.geometry import Shape
from protocol.scenario.model import Point, RobotSpec, Thing, Workspace

_TRIES = 30
_GAPS = (1e-6, 1e-3, 0.3)  # of the radius, between a robot and what it begins beside
_WALL_GAPS = (1e-9, 1e-6, 1e-3, 0.1)  # of the workspace's radius, between robots and straight walls


def around(dice: Dice, workspace: Workspace, robots: Sequence[RobotSpec]) -> Workspace:
    """The same round workspace, or a polygon: around it, or as close around all robots as walls can stand."""
    if dice.chance(0.65):
        return workspace
    if dice.chance(0.3):
        return Workspace(points=_regular(dice, workspace.disk_radius))
    walls = _walls(dice)
    gap = workspace.disk_radius * dice.pick(_WALL_GAPS)
    sides = [
        (
            nx,
            ny,
            max(nx * x + ny * y + robot.radius for robot in robots for x, y in (robot.start, robot.goal)),
        )
        for nx, ny in walls
    ]
    corners = _enclosed([(nx, ny, offset + gap) for nx, ny, offset in sides], 4.0 * workspace.disk_radius)
    return Workspace(points=corners) if len(corners) >= 3 else workspace


def _regular(dice: Dice, radius: float) -> tuple[Point, ...]:
    """Corners of a regular polygon around the workspace."""
    sides, turn = dice.whole(3, 8), dice.uniform(0.0, math.tau)
    reach = radius / math.cos(math.pi / sides)
    angles = [turn + math.tau * side / sides for side in range(sides)]
    return tuple((reach * math.cos(angle), reach * math.sin(angle)) for angle in angles)


def _walls(dice: Dice) -> list[Point]:
    """Outward normals of three to seven walls; some rooms have acute corners, some are narrow."""
    turn = dice.uniform(0.0, math.tau)
    angles = [math.tau * dice.uniform(0.0, 1.0) for _ in range(dice.whole(0, 4))]
    angles += [turn, turn + dice.uniform(1.6, 3.1), turn + dice.uniform(3.2, 4.6)]
    return [(math.cos(angle), math.sin(angle)) for angle in angles]


def _enclosed(sides: Sequence[tuple[float, float, float]], far: float) -> tuple[Point, ...]:
    """Corners of what all half-planes n.x <= offset leave of a large square, counterclockwise."""
    corners: list[Point] = [(-far, -far), (far, -far), (far, far), (-far, far)]
    for nx, ny, offset in sides:
        left: list[Point] = []
        for place, (x, y) in enumerate(corners):
            px, py = corners[place - 1]
            room, before = offset - nx * x - ny * y, offset - nx * px - ny * py
            if (room < 0.0) != (before < 0.0):
                part = before / (before - room)
                left.append((px + part * (x - px), py + part * (y - py)))
            if room >= 0.0:
                left.append((x, y))
        corners = left
    return tuple(corners)


def things(dice: Dice, robots: Sequence[RobotSpec], workspace: float, room: Shape) -> tuple[Thing, ...]:
    """None in most scenarios; else a few disks and polygons on which nobody begins or is to be.

    Half of them stand right beside a robot. `workspace` is its radius, m.
    """
    if not dice.chance(0.35):
        return ()
    drawn = [one_thing(dice, robots, workspace, (0.0, 0.0)) for _ in range(_TRIES)]
    clear = [
        thing
        for thing in drawn
        if room.distance(thing.shape.around.x, thing.shape.around.y) < 0.0
        and all(
            thing.shape.distance(*point) > robot.radius
            for robot in robots
            for point in (robot.start, robot.goal)
        )
    ]
    return tuple(clear[: dice.whole(1, 5)])


def one_thing(dice: Dice, robots: Sequence[RobotSpec], workspace: float, centre: Point) -> Thing:
    """A disk or a polygon, half of the time right beside where a robot begins.

    Args:
        workspace, centre: of a disk in which the middle is, m.
    """
    size = workspace * dice.log_uniform(0.005, 0.3)
    angle, turn = dice.uniform(0.0, math.tau), dice.uniform(0.0, math.tau)
    if dice.chance(0.5):
        robot = dice.pick(robots)
        x, y = robot.start
        far = size + robot.radius * (1.0 + dice.pick(_GAPS))
    else:
        (x, y), far = centre, workspace * math.sqrt(dice.uniform(0.0, 1.0))
    middle = (x + far * math.cos(angle), y + far * math.sin(angle))
    if dice.chance(0.4):
        return Thing(center=middle, radius=size)
    return Thing(points=_polygon(dice, middle, size, turn))


def _polygon(dice: Dice, centre: Point, size: float, turn: float) -> tuple[Point, ...]:
    """Corners on an ellipse, one of which is `turn` away from its long axis."""
    corners, flat = dice.pick((3, 4, 4, 5, 8)), dice.pick((1.0, dice.log_uniform(0.02, 1.0)))
    cos, sin = math.cos(turn), math.sin(turn)
    points = []
    for corner in range(corners):
        u = size * math.cos(math.tau * corner / corners)
        v = size * flat * math.sin(math.tau * corner / corners)
        points.append((centre[0] + cos * u - sin * v, centre[1] + sin * u + cos * v))
    return tuple(points)
