"""Figure 3: five goal sets of six robots, from easy to tight.

Karagoz, Bozma, Koditschek state how tight their goal sets are, not where the goals are. These were
found by a seeded random search for sets of that tightness; of those within 0.005 of it, the one with
the largest clearance between goals and to the boundary was kept.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations

from deploy.library.figures import RADIUS, WORKSPACE, paper_scenario
from deploy.library.random_instances import random_starts
from protocol.errors import UsageError
from protocol.scenario.model import Point, Scenario

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
