"""Measures of a run and of a goal set (Karagoz, Bozma, Koditschek, section 4)."""

from __future__ import annotations

import math
from itertools import combinations

from protocol.scenario.model import Scenario

_CENTIMETRES = 100.0


def tight(scenario: Scenario) -> float | None:
    """Tightness of the goals: 100 / log10 of the product over pairs of |g_ij|^2 - rho_ij^2, in cm.

    None where the measure has no meaning: fewer than two robots, goals that touch or overlap, or
    goals so close that the logarithm is not positive.
    """
    total = 0.0
    for one, other in combinations(scenario.robots, 2):
        contact = _CENTIMETRES * (one.radius + other.radius)
        distance = _CENTIMETRES * math.dist(one.goal, other.goal)
        factor = distance**2 - contact**2
        if factor <= 0.0:
            return None
        total += math.log10(factor)
    return 100.0 / total if total > 0.0 else None


def normalised_length(scenario: Scenario, lengths: dict[int, float]) -> float | None:
    """nrl: path lengths (m, by robot id) over straight distances from start to goal, summed over robots.

    None when every robot starts at its goal.
    """
    straight = math.fsum(math.dist(spec.start, spec.goal) for spec in scenario.robots)
    return math.fsum(lengths.values()) / straight if straight > 0.0 else None
