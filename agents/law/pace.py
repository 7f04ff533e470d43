"""Pace: the positive scale s of the flow y' = -s D(y), 1/s, and which robot moves next.

Any positive scale descends phi; a scale common to all robots also keeps the paper's path, because the
whole configuration then moves along -D. Along the motion of one robot alone phi descends, too, as each
follows its own slice of the same gradient: robots that take turns minimize it by coordinate descent.

The maximum rate is the largest scale. Close to its goal a robot obeys y' = -2 s (y - g), so at that rate
it brakes exponentially from the distance speed / (2 max_rate) on. With
max_rate = 1 / (2 max(period, tolerance/speed)) that
distance is the arrival tolerance, or one period's way if that is longer: arrival has no tail, and a period
shortens the distance by a factor of at most e, so robots that know each other late do not overshoot.
"""

from __future__ import annotations

import math
from typing import final

from protocol.scenario.model import Scenario


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


@final
class Turn:
    """When it is the turn of one robot.

    Args:
        place: of the robot in the order of ids, from 0.
        robots: how many take turns.
        ticks: that a turn lasts.
    """

    def __init__(self, place: int, robots: int, ticks: int) -> None:
        self._place, self._robots, self._ticks = place, robots, ticks

    def has_come(self, tick: int) -> bool:
        """Whether the robot may move in a tick."""
        return tick // self._ticks % self._robots == self._place


def turn_of(scenario: Scenario, robot: int) -> Turn | None:
    """The turn of a robot; None where all move at once, as they do unless `control.turn` is given."""
    if scenario.control.turn is None:
        return None
    ids = scenario.ids
    return Turn(ids.index(robot), len(ids), scenario.ticks(scenario.control.turn))
