"""Parts beside robots that are drawn already, to be carried a little way: there is little time."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

from deploy.studies.falsify.scenarios.dice import Dice
from deploy.studies.falsify.scenarios.places import anywhere, beside
from protocol.geometry import Disk, Shape
from protocol.scenario.model import Carrying, Part, Point, RobotSpec, Scenario, Thing

_TRIES = 12
_MOST = 3
_SMALLEST = 0.16  # of the room, the smallest robot among which parts are drawn: ways are planned on a grid
_GAPS = (0.0, 1e-6, 0.1, 0.5, 1.0)  # of the reach, between a part and what it stands beside


def loads(
    dice: Dice,
    robots: Sequence[RobotSpec],
    standing: Iterable[Thing],
    room: Shape,
    some: float = 0.4,
) -> tuple[tuple[Part, ...], Carrying]:
    """None in most scenarios; else a few, many of them larger than robots, and how far these reach.

    Args:
        some: probability of any.
    """
    smallest = min(robot.radius for robot in robots)
    if not dice.chance(some) or smallest < _SMALLEST * room.around.radius:
        return (), Carrying()
    carrying = Carrying(smallest * dice.pick((0.1, 0.3, dice.log_uniform(0.03, 2.0))))
    things = [thing.shape for thing in standing]
    starts: list[Shape] = [*things, *(Disk(*robot.start, robot.radius) for robot in robots)]
    goals: list[Shape] = [*things, *(Disk(*robot.goal, robot.radius) for robot in robots)]
    alike, found = dice.chance(0.5), list[Part]()
    for _ in range(_TRIES):
        radius = found[0].radius if alike and found else smallest * dice.log_uniform(0.7, 2.5)
        start = _start(dice, robots, found, radius, carrying.reach, room)
        goal = _goal(dice, start, radius, smallest, room)
        if _is_free(start, radius, starts, room) and _is_free(goal, radius, goals, room):
            found.append(Part(radius, start, goal))
            starts.append(Disk(*start, radius))
            goals.append(Disk(*goal, radius))
    return tuple(found[: dice.whole(1, _MOST)]), carrying


def by_points(scenario: Scenario) -> Scenario:
    """Where there are parts, robots that are points and hear everybody: others cannot carry them."""
    if not scenario.parts:
        return scenario
    robots = tuple(replace(robot, body=None) for robot in scenario.robots)
    return replace(scenario, robots=robots, body="point", network=replace(scenario.network, interest="all"))


def _start(
    dice: Dice, robots: Sequence[RobotSpec], parts: Sequence[Part], radius: float, reach: float, room: Shape
) -> Point:
    """Beside a robot or another part, or anywhere."""
    point = _somewhere(dice, room)
    if dice.chance(0.2):
        return point
    others: list[RobotSpec | Part] = [*robots, *parts]
    other = dice.pick(others)
    return beside(other.start, other.radius, point, radius, reach * dice.pick(_GAPS))


def _goal(dice: Dice, start: Point, radius: float, unit: float, room: Shape) -> Point:
    """Not far off, or anywhere."""
    if dice.chance(0.3):
        return _somewhere(dice, room)
    angle, away = dice.uniform(0.0, math.tau), radius + unit * dice.uniform(0.0, 4.0)
    return start[0] + away * math.cos(angle), start[1] + away * math.sin(angle)


def _somewhere(dice: Dice, room: Shape) -> Point:
    x, y = anywhere(dice, room.around.radius)
    return room.around.x + x, room.around.y + y


def _is_free(point: Point, radius: float, others: Iterable[Shape], room: Shape) -> bool:
    inside = room.distance(*point) + radius < 0.0
    return inside and all(shape.distance(*point) > radius for shape in others)
