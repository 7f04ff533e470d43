"""Measures of a run and of a goal set (Karagoz, Bozma, Koditschek, section 4)."""

from __future__ import annotations

import math

from world.judge.clearance import Disks
from world.judge.goals import Goals

_CENTIMETRES = 100.0


def tight(disks: Disks, goals: Goals) -> float | None:
    """Tightness of the goals: 100 / log10 of the product over pairs of |g_ij|^2 - rho_ij^2, in cm.

    None where the measure has no meaning: fewer than two robots, goals that touch or overlap, or
    goals so close that the logarithm is not positive.
    """
    apart = disks.relative(goals.points)
    factors = _CENTIMETRES**2 * (apart.real**2 + apart.imag**2 - disks.contact**2)
    if (factors <= 0.0).any():
        return None
    total = math.fsum(math.log10(factor) for factor in factors)
    return 100.0 / total if total > 0.0 else None


def normalised_length(goals: Goals, lengths: dict[int, float]) -> float | None:
    """nrl: path lengths (m, by robot id) over straight distances to the goals, summed over robots.

    None when every robot starts at its goal.
    """
    straight = goals.straight
    return math.fsum(lengths.values()) / straight if straight > 0.0 else None
