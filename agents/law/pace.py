"""Pace: the positive scale s of the flow y' = -s D(y), 1/s, and which robot moves next.

Phi decreases with any positive scale; one common to all robots also keeps the paper's path, because the whole
configuration then moves along -D. Robots that take turns minimize phi by coordinate descent.

Close to its goal a robot obeys y' = -2 s (y - g), so with the largest scale, max_rate, it brakes
exponentially from the distance speed / (2 max_rate) on. With max_rate = 1 / (2 max(period, tolerance/speed))
that is the arrival tolerance, or the motion of one period if that is longer: arrival is not delayed, and a
period shortens the distance by a factor of at most e, so robots do not overshoot with late States.
"""

from __future__ import annotations

import math

from protocol.scenario.model import Scenario


def max_rate(speed: float, period: float, tolerance: float) -> float:
    """Largest scale, 1/s, from the speed limit (m/s), the period (s) and the arrival tolerance (m)."""
    return 0.5 / max(period, tolerance / speed)


def common_pace(slice_norm: float, gamma: float, speed: float, limit: float) -> float:
    """The scale at which the fastest robot moves at the speed limit, 1/s, at most the maximum rate.

    min(speed / max_j |D_j|, max_rate), where |D_j| is limited to the largest attraction 2 sqrt(max_j
    gamma_j): a squeezed robot has an enormous slice for a moment, which must not stop all others.

    Args:
        slice_norm: largest known |D_j| of all robots, m, own included.
        gamma: largest gamma_j = |b_j - g_j|^2 of all robots, m^2, own included.
        speed: speed limit, m/s.
        limit: the maximum rate, 1/s.
    """
    largest = min(slice_norm, 2.0 * math.sqrt(gamma))
    return min(speed / largest, limit) if largest > 0.0 else limit


def may_move(scenario: Scenario, robot: int, tick: int) -> bool:
    """Whether a robot may move in a tick: always, unless `control.turn` lets one move at a time, by id."""
    turn = scenario.control.turn
    if turn is None:
        return True
    ids = scenario.ids
    return tick // scenario.ticks(turn) % len(ids) == ids.index(robot)
