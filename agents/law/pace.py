"""Pace: the positive scale s of the flow y' = -s D(y), 1/s.

Any positive scale descends phi; a scale common to all robots also keeps the paper's path, because the
whole configuration then moves along -D.

The maximum rate is the largest scale. Close to its goal a robot obeys y' = -2 s (y - g), so at that rate
it brakes exponentially from the distance speed / (2 max_rate) on. With
max_rate = 1 / (2 max(period, tolerance/speed)) that
distance is the arrival tolerance, or one period's way if that is longer: arrival has no tail, and a period
shortens the distance by a factor of at most e, so robots that know each other late do not overshoot.
"""

from __future__ import annotations

import math


def max_rate(speed: float, period: float, tolerance: float) -> float:
    """Largest scale, 1/s, from the speed limit (m/s), the period (s) and the arrival tolerance (m)."""
    return 0.5 / max(period, tolerance / speed)


def own_pace(limit: float) -> float:
    """The scale of a robot that saturates by itself: the maximum rate; the flow keeps to the speed limit."""
    return limit


def common_pace(slice_norm: float, gamma: float, speed: float, limit: float) -> float:
    """The scale at which the fastest robot just moves at the speed limit, 1/s, at most the maximum rate.

    min(speed / max_j |D_j|, max_rate), where no |D_j| counts for more than the largest attraction
    2 sqrt(max_j gamma_j). Along the flow the repulsion only deflects the attraction and the bound is
    idle; but a robot that is squeezed for a moment has an enormous slice, relaxed within a fraction of
    a period, and must not freeze all the others meanwhile. It is then slowed by its own speed limit alone.

    Args:
        slice_norm: largest |D_j| of all robots, m, own included, as known.
        gamma: largest gamma_j = |b_j - g_j|^2 of all robots, m^2, own included.
        speed: speed limit, m/s.
        limit: the maximum rate, 1/s.
    """
    largest = min(slice_norm, 2.0 * math.sqrt(gamma))
    return min(speed / largest, limit) if largest > 0.0 else limit
