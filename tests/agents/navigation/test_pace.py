from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.navigation.flow import Flow, desired_velocity
from agents.navigation.pace import AT_ALL, HASTE, WHOLLY, common_pace, hastened, max_rate, own_pace
from agents.navigation.slice import Slice


def test_the_fastest_robot_moves_at_the_speed_limit() -> None:
    assert common_pace(0.4, 0.09, 0.1, 10.0) == pytest.approx(0.25)


def test_a_squeezed_robot_does_not_freeze_the_others() -> None:
    farthest = 0.3
    scale = common_pace(1e6, farthest**2, 0.1, 10.0)
    assert scale * 2 * farthest == pytest.approx(0.1)


def test_the_gain_is_the_largest_scale() -> None:
    assert common_pace(1e-9, 1e-18, 0.1, 10.0) == 10.0
    assert common_pace(0.0, 0.0, 0.1, 10.0) == 10.0
    assert own_pace(10.0) == 10.0


@pytest.mark.parametrize("period", [0.02, 0.05, 0.1, 0.2])
def test_arrival_has_no_tail_and_no_overshoot(period: float) -> None:
    speed, tolerance, x, ticks = 0.1, 0.005, 0.25, 0
    own = Slice((0.0, 0.0), 0.04, 0.35, 60.0, [])
    scale = max_rate(speed, period, tolerance)
    while x > tolerance:
        step = desired_velocity(Flow(own, scale), (x, 0.0), period=period, speed=speed)[0] * period
        assert -x < step < 0.0
        x += step
        ticks += 1
    straight = (0.25 - tolerance) / speed
    assert ticks * period <= straight + 4 * period + 0.2
    rest = [x]
    for _ in range(40):
        rest.append(
            rest[-1]
            + period * desired_velocity(Flow(own, scale), (rest[-1], 0.0), period=period, speed=speed)[0]
        )
    assert rest == sorted(rest, reverse=True)
    assert 0.0 <= rest[-1] < 1e-9
    assert math.isfinite(rest[-1])


@given(st.floats(0.0, 20.0), st.floats(0.0, 5.0))
def test_only_who_knows_the_others_late_and_is_near_its_goal_makes_haste(away: float, latency: float) -> None:
    speed = hastened(0.3, away, latency)
    assert 0.3 <= speed <= 0.3 * (1.0 + HASTE)
    assert speed == 0.3 or (away < AT_ALL and latency > 0.0)
    assert hastened(0.3, away, latency + 0.1) >= speed >= hastened(0.3, away + 0.1, latency)
    if away <= WHOLLY and latency >= 1.0:
        assert speed == 0.3 * (1.0 + HASTE)
