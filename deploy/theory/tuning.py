"""The rule of k = "auto": the gain for the size and density of a fleet, or for the narrow passages on its
paths.

docs/theory/auto-k.md derives the rule.

The two corners of a gap of width w repel a robot of radius rho. On the middle line, at distance y from the
gap, beta of each is y^2 + e^2 with e^2 = (w/2)^2 - rho^2; together they push with (gamma/k) 4 y / (y^2 +
e^2), at most 2 gamma / (k e). The attraction is 2 a, with a the length of the remaining path. So the robot
passes if k > gamma / (a e). If all robots that are not at their goals are held back, gamma is at most p a^2
for the one with the longest remaining path: it passes if k > p a / e. For a disk of radius r, e^2 = (r +
w/2)^2 - (r + rho)^2; a straight wall only pushes sideways.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Final, NamedTuple

import numpy as np

from agents.law.obstacles import Attraction
from agents.law.passages import OUTSIDE, Gap, crosses, gaps
from protocol.arrays import Reals
from protocol.geometry import Disk, Shape, signed_area
from protocol.messages import Vector
from protocol.scenario.model import RobotSpec, Scenario

RESERVE: Final = 2.0  # over the least gain: peers, and obstacles beside a door, push as well


class Door(NamedTuple):
    """A passage on the path of one robot."""

    robot: int
    gap: Gap
    left: float  # m, remaining path from there to the goal
    gain: float  # k above which the robot passes, even if all others have as long a remaining path


def doors(scenario: Scenario, above: float) -> list[Door]:
    """All passages on the paths from starts to goals that need a gain above `above`."""
    room, obstacles = scenario.workspace.shape, tuple(scenario.shapes.values())
    if not obstacles:
        return []
    count, found = len(scenario.robots), []
    pulls = {spec.radius: Attraction(room, spec.radius, alone=count == 1) for spec in scenario.robots}
    ways = []  # length and width of each robot's path
    for spec in scenario.robots:
        pull = pulls[spec.radius]
        ways.append((math.dist(spec.start, pull.aim(spec.start, spec.goal, obstacles)), pull.width))
    longest = max(length for length, _ in ways)
    near = gaps(room, obstacles, 2.0 * math.hypot(max(pulls), count * longest / above))
    for spec, (length, width) in zip(scenario.robots, ways, strict=True):
        passed = [gap for gap in near if gap.width > width and _longer(spec, gap) <= length]
        holds = [(gap, count * _hold(obstacles, gap, spec.radius)) for gap in passed]
        narrow = [(gap, hold) for gap, hold in holds if length * hold > above]
        way = [spec.start, *pulls[spec.radius].way(spec.start, spec.goal, obstacles)] if narrow else []
        for gap, hold in narrow:
            left = _left(way, gap)
            if left * hold > above:
                found.append(Door(spec.id, gap, left, left * hold))
    return found


def _longer(spec: RobotSpec, gap: Gap) -> float:
    """Lower bound of the length of a path through a gap, m."""
    middle = 0.5 * (gap.begin[0] + gap.end[0]), 0.5 * (gap.begin[1] + gap.end[1])
    return math.dist(spec.start, middle) + math.dist(middle, spec.goal) - gap.width


def _left(way: Sequence[Vector], gap: Gap) -> float:
    """Remaining length of a path where it last passes through a gap, m; 0 if it does not."""
    left = 0.0
    for b, a in pairwise(reversed(way)):
        if crosses(a, b, gap.begin, gap.end):
            return left + math.dist(b, gap.begin)
        left += math.dist(a, b)
    return 0.0


def _hold(obstacles: tuple[Shape, ...], gap: Gap, radius: float) -> float:
    """Sum of 1 / 2e over both sides, 1/m."""
    total = 0.0
    for index in (gap.one, gap.other):
        if index != OUTSIDE:
            shape = obstacles[index]
            size = shape.radius if isinstance(shape, Disk) else 0.0
            total += 0.5 / math.sqrt((size + 0.5 * gap.width) ** 2 - (size + radius) ** 2)
    return total


PAPER_K = 60.0  # the gain of the paper's six robots (section 4)
PAPER_ROBOTS = 6.0
SPARSE = 0.15  # density up to which only the number of robots matters


def density(radii: Reals, workspace: float) -> float:
    return float((np.asarray(radii) ** 2).sum() / workspace**2)


def gain_for(scenario: Scenario) -> float:
    """The k for "auto": that of the fleet, or of the narrowest doors on its paths."""
    k = automatic_k(*crowd(scenario))
    return max([k, *(RESERVE * door.gain for door in doors(scenario, k / RESERVE))])


def crowd(scenario: Scenario) -> tuple[Reals, float]:
    """Radii of robots and obstacles, and of the workspace, m; shapes other than disks by their area."""
    obstacles = [_round(shape) for shape in scenario.shapes.values()]
    radii = np.array([*(robot.radius for robot in scenario.robots), *obstacles])
    return radii, _round(scenario.workspace.shape)


def _round(shape: Shape) -> float:
    return shape.radius if isinstance(shape, Disk) else math.sqrt(signed_area(shape.points) / math.pi)


def automatic_k(radii: Reals, workspace: float) -> float:
    """A gain k with which p robots of these radii (m) arrive in a workspace of this radius (m).

    60 max(1, (p / 6)^2, (density / 0.15)^2). gamma is a sum over robots, so the repulsive layer gamma / k
    must become thinner with their number; in a crowded workspace narrow gaps must be open. The bounds of
    Theorem 1 are not used: they may not exist, and are many orders of magnitude larger.
    """
    crowd = max(1.0, len(radii) / PAPER_ROBOTS, density(radii, workspace) / SPARSE)
    return PAPER_K * crowd**2
