"""The figures of Karagoz, Bozma, Koditschek, and scenarios to be seen rather than measured.

The paper gives no numbers for figures 1 and 2; these show what it shows. Of figure 3 it states how tight the
goal sets are, not where the goals are: these were found by a seeded random search for sets of that tightness;
of those within 0.005 of it, the one with the largest clearance between goals and to the boundary was kept.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import combinations
from math import cos, pi, sin

from deploy.library.random_instances import random_starts
from protocol.errors import UsageError
from protocol.scenario.file import validated
from protocol.scenario.model import Control, Link, Point, ProcessFault, RobotSpec, Scenario, Workspace

RADIUS = 0.04  # m
WORKSPACE = 0.30  # m
GAIN = 60.0  # the paper's k


def paper_scenario(
    name: str, description: str, seed: int, starts: Iterable[Point], goals: Iterable[Point]
) -> Scenario:
    """Equal robots 1, 2, ... in the paper's setting: radius 0.04 m in a workspace of 0.30 m, k = 60."""
    robots = tuple(
        RobotSpec(n, RADIUS, start, goal)
        for n, (start, goal) in enumerate(zip(starts, goals, strict=True), start=1)
    )
    return validated(Scenario(robots, name, description, seed, Workspace(WORKSPACE), control=Control(k=GAIN)))


def figure_1(seed: int = 0) -> Scenario:
    """Robot 1 must pass between 2 and 3, then between 4 and 5, which stand close to their goals."""
    starts = [(-0.24, 0.0), (-0.07, 0.05), (-0.07, -0.05), (0.09, 0.05), (0.09, -0.05), (0.02, 0.22)]
    goals = [(0.24, 0.0), (-0.06, 0.05), (-0.06, -0.05), (0.08, 0.05), (0.08, -0.05), (-0.04, 0.20)]
    text = "robot 1 passes between 2 and 3, then 4 and 5, which nudge aside and return"
    return paper_scenario("figure-1", text, seed, starts, goals)


def figure_2(seed: int = 0) -> Scenario:
    """Goals 5 mm apart, each robot on the far side from its own: they meet in each other's way.

    Violates Assumption 1, so the theory promises nothing. At this k the blockade is a saddle, which the
    flow leaves by circling; below k = 3 some starts stay blocked.
    """
    goals = [(0.0, 0.049), (-0.0425, -0.0245), (0.0425, -0.0245)]
    starts = [(0.01, -0.22), (0.19, 0.11), (-0.19, 0.12)]
    text = "three robots whose goals are too close together: Assumption 1 is violated"
    return paper_scenario("figure-2", text, seed, starts, goals)


GOAL_SETS: dict[str, tuple[Point, ...]] = {
    "a": (
        (-0.102, -0.18),
        (-0.059, 0.153),
        (0.149, -0.131),
        (0.149, 0.104),
        (-0.033, -0.028),
        (-0.205, -0.041),
    ),
    "b": ((0.0, 0.013), (0.153, -0.052), (0.123, 0.092), (-0.135, 0.084), (-0.143, -0.094), (-0.006, -0.151)),
    "c": (
        (-0.015, 0.054),
        (-0.132, 0.055),
        (0.095, -0.008),
        (0.038, -0.141),
        (0.088, 0.119),
        (-0.087, -0.061),
    ),
    "d": (
        (0.061, 0.073),
        (-0.102, -0.03),
        (0.139, -0.017),
        (-0.038, 0.039),
        (0.024, -0.044),
        (-0.036, -0.113),
    ),
    "e": ((-0.075, -0.069), (-0.042, 0.03), (0.024, -0.132), (0.035, -0.03), (0.062, 0.07), (0.104, -0.085)),
}
TIGHTNESS = {"a": 2.44, "b": 2.63, "c": 2.87, "d": 3.30, "e": 3.45}  # the paper's figures


def tightness(goals: Sequence[Point], radii: Sequence[float]) -> float:
    """`tight` of the paper's section 4: 100 / log10 prod(|g_ij|^2 - rho_ij^2) in cm; arguments in m."""
    total = 0.0
    for (g, r), (h, s) in combinations(zip(goals, radii, strict=True), 2):
        total += math.log10(1e4 * (math.dist(g, h) ** 2 - (r + s) ** 2))
    return 100.0 / total


def figure_3(letter: str, seed: int = 0) -> Scenario:
    """Goal set `letter` ("a" to "e") from random starts; each seed gives other starts.

    Raises:
        UsageError: there is no such goal set.
    """
    if letter not in GOAL_SETS:
        raise UsageError(f"no goal set {letter!r}; there are {', '.join(GOAL_SETS)}")
    starts = random_starts([RADIUS] * 6, WORKSPACE, seed)
    text = f"six robots, goal set {letter} of tightness {TIGHTNESS[letter]:.2f}, random starts"
    return paper_scenario(f"figure-3{letter}", text, seed, starts, GOAL_SETS[letter])


def delay_6(seed: int = 0) -> Scenario:
    """Figure 3d where states arrive up to 0.3 s late, out of order, and one in ten never."""
    return replace(
        figure_3("d", seed),
        name="delay-6",
        description="figure-3d with states delayed by 0 to 0.3 s, 10 % of them lost",
        link=Link(delay=(0.0, 0.3), loss=0.1),
    )


def crash(seed: int = 0) -> Scenario:
    """Figure 3c where the process of robot 3 is killed on the way and started again."""
    return replace(
        figure_3("c", seed),
        name="crash",
        description="figure-3c; robot 3 is killed at 1 s and started again at 3 s",
        process=(ProcessFault(3, 1.0, "kill"), ProcessFault(3, 3.0, "restart")),
    )


def admissible(seed: int = 0) -> Scenario:
    """Three robots far enough apart, in room enough, that the paper's Assumptions 1 and 2 hold.

    They start where their neighbour's goal is: nobody can go straight, yet nobody has to squeeze.
    """
    goals = [
        (0.3 * cos(angle), 0.3 * sin(angle)) for angle in (pi / 2, pi / 2 + 2 * pi / 3, pi / 2 - 2 * pi / 3)
    ]
    robots = tuple(
        RobotSpec(index + 1, 0.04, start, goal)
        for index, (start, goal) in enumerate(zip(goals[1:] + goals[:1], goals, strict=True))
    )
    return Scenario(
        robots,
        name="admissible",
        description="three robots with goals that satisfy the paper's assumptions",
        seed=seed,
        workspace=Workspace(0.9),
    )
