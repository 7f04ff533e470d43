"""What stands around robots that are drawn already, and what encloses them."""

from __future__ import annotations

import math
from collections.abc import Sequence

from deploy.studies.falsify.scenarios.dice import Dice
from protocol.scenario.model import Point, RobotSpec, Thing, Workspace

_TRIES = 30
_GAPS = (1e-6, 1e-3, 0.3)  # of the radius, between a robot and what it begins beside


def around(dice: Dice, workspace: Workspace) -> Workspace:
    """The same round workspace, or a polygon around it."""
    if not dice.chance(0.15):
        return workspace
    sides, turn = dice.whole(3, 8), dice.uniform(0.0, math.tau)
    reach = workspace.disk_radius / math.cos(math.pi / sides)
    angles = [turn + math.tau * side / sides for side in range(sides)]
    return Workspace(points=tuple((reach * math.cos(angle), reach * math.sin(angle)) for angle in angles))


def things(dice: Dice, robots: Sequence[RobotSpec], workspace: float) -> tuple[Thing, ...]:
    """None in most scenarios; else a few disks and polygons on which nobody begins or is to be.

    Half of them stand right beside a robot. `workspace` is its radius, m.
    """
    if not dice.chance(0.3):
        return ()
    drawn = [_thing(dice, robots, workspace) for _ in range(_TRIES)]
    clear = [
        thing
        for thing in drawn
        if math.hypot(thing.shape.around.x, thing.shape.around.y) < workspace
        and all(
            thing.shape.distance(*point) > robot.radius
            for robot in robots
            for point in (robot.start, robot.goal)
        )
    ]
    return tuple(clear[: dice.whole(1, 5)])


def _thing(dice: Dice, robots: Sequence[RobotSpec], workspace: float) -> Thing:
    size = workspace * dice.log_uniform(0.005, 0.3)
    angle, turn = dice.uniform(0.0, math.tau), dice.uniform(0.0, math.tau)
    if dice.chance(0.5):
        robot = dice.pick(robots)
        x, y = robot.start
        far = size + robot.radius * (1.0 + dice.pick(_GAPS))
    else:
        x, y, far = 0.0, 0.0, workspace * math.sqrt(dice.uniform(0.0, 1.0))
    centre = (x + far * math.cos(angle), y + far * math.sin(angle))
    if dice.chance(0.4):
        return Thing(center=centre, radius=size)
    return Thing(points=_polygon(dice, centre, size, turn))


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
