"""The rule behind k = "auto": what a crowd needs, or what leads through the narrow passages on the ways.

docs/theory/auto-k.md derives the rule.

Before a gap of width w between two corners the repulsion of the corners holds a robot of radius rho back. On
the middle line, at the distance y from the gap, beta of each is y^2 + e^2 with e^2 = (w/2)^2 - rho^2; the two
together push with (gamma/k) 4 y / (y^2 + e^2), at most 2 gamma / (k e). The attraction is 2 a, a the length
of the way left. So the robot passes if k > gamma / (a e). Where all robots that are not at their goals are
held back, gamma is at most p a^2 for the one with the longest way left: it passes if k > p a / e. Of a disk
of radius r, e^2 = (r + w/2)^2 - (r + rho)^2; a straight wall pushes aside only.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Final, NamedTuple

import numpy as np

from agents.law.obstacles import Attraction
from agents.law.passages import OUTSIDE, Gap, crosses, gaps
from deploy.theory.function import Array
from protocol.geometry import Disk, Shape
from protocol.messages import Vector
from protocol.scenario.model import RobotSpec, Scenario

RESERVE: Final = 2.0  # times the least gain: what stands beside a door, and peers, push as well


class Door(NamedTuple):
    """A passage on the way of one robot."""

    robot: int
    gap: Gap
    left: float  # m, of the way from there to the goal
    gain: float  # k above which the robot passes, all others with as long a way left


def doors(scenario: Scenario, above: float) -> list[Door]:
    """All passages on the ways from starts to goals that need a gain of more than `above`."""
    room, obstacles = scenario.workspace.shape, tuple(scenario.shapes.values())
    if not obstacles:
        return []
    count, found = len(scenario.robots), []
    pulls = {spec.radius: Attraction(room, spec.radius, alone=count == 1) for spec in scenario.robots}
    ways = []  # of each robot: how long, and through how narrow gaps
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
    """No way through a gap is shorter, m."""
    middle = 0.5 * (gap.begin[0] + gap.end[0]), 0.5 * (gap.begin[1] + gap.end[1])
    return math.dist(spec.start, middle) + math.dist(middle, spec.goal) - gap.width


def _left(way: Sequence[Vector], gap: Gap) -> float:
    """What is left of a way where it last passes through a gap, m; 0 if it does not."""
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
SPARSE = 0.15  # density up to which the number of robots alone decides


def density(radii: Array, workspace: float) -> float:
    """Area of the disks over area of the workspace."""
    return float((np.asarray(radii) ** 2).sum() / workspace**2)


def gain_for(scenario: Scenario) -> float:
    """The k that "auto" stands for: that of the crowd, or what the narrowest doors on the ways need."""
    k = automatic_k(*crowd(scenario))
    return max([k, *(RESERVE * door.gain for door in doors(scenario, k / RESERVE))])


def crowd(scenario: Scenario) -> tuple[Array, float]:
    """Radii of everything that is in the way, robots first, and of the workspace, m, as `automatic_k` takes
    them; what is not round counts by its area."""
    obstacles = [_round(shape) for shape in scenario.shapes.values()]
    radii = np.array([*(robot.radius for robot in scenario.robots), *obstacles])
    return radii, _round(scenario.workspace.shape)


def _round(shape: Shape) -> float:
    return shape.radius if isinstance(shape, Disk) else math.sqrt(shape.area / math.pi)


def automatic_k(radii: Array, workspace: float) -> float:
    """A gain k at which p robots of these radii (m) arrive in a workspace of this radius (m).

    60 max(1, (p / 6)^2, (density / 0.15)^2). gamma is a sum over robots, so the repulsive layer gamma / k
    must be thinned as they grow in number; few robots in a crowded workspace need narrow gaps to be open.
    Neither bound of Theorem 1 is used: where it exists it is many orders of magnitude larger.
    """
    crowd = max(1.0, len(radii) / PAPER_ROBOTS, density(radii, workspace) / SPARSE)
    return PAPER_K * crowd**2
