"""The common pace, near and far, and the rate that brakes before a goal."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.law import View, choose
from agents.law.flow import Flow, desired_velocity
from agents.law.gradient import Slice
from agents.law.late_states import FAST_AT_ALL, FAST_IN_FULL, HASTE, late_speed
from agents.law.pace import common_pace, max_rate
from agents.peers.far import FarField
from agents.peers.neighbours import Neighbours
from protocol.scenario.model import Control, RobotSpec, Scenario


def test_the_fastest_robot_moves_at_the_speed_limit() -> None:
    assert common_pace(0.4, 0.09, 0.1, 10.0) == pytest.approx(0.25)


def test_a_squeezed_robot_does_not_freeze_the_others() -> None:
    farthest = 0.3
    scale = common_pace(1e6, farthest**2, 0.1, 10.0)
    assert scale * 2 * farthest == pytest.approx(0.1)


@pytest.mark.parametrize("period", [0.02, 0.05, 0.1, 0.2])
def test_arrival_has_no_tail_and_no_overshoot(period: float) -> None:
    speed, tolerance, x, ticks = 0.1, 0.005, 0.25, 0
    own = Slice((0.0, 0.0), 0.04, 0.35, 60.0, [])
    scale = max_rate(speed, period, tolerance)

    def step(x: float) -> float:
        return period * desired_velocity(Flow(own, scale), (x, 0.0), period=period, speed=speed)[0]

    while x > tolerance:
        assert -x < step(x) < 0.0
        x += step(x)
        ticks += 1
    straight = (0.25 - tolerance) / speed
    assert ticks * period <= straight + 4 * period + 0.2
    rest = [x]
    for _ in range(40):
        rest.append(rest[-1] + step(rest[-1]))
    assert rest == sorted(rest, reverse=True)
    assert 0.0 <= rest[-1] < 1e-9
    assert math.isfinite(rest[-1])


@given(st.floats(0.0, 20.0), st.floats(0.0, 5.0))
def test_only_a_robot_near_its_goal_with_late_peers_makes_haste(away: float, latency: float) -> None:
    speed = late_speed(0.3, away, latency)
    assert 0.3 <= speed <= 0.3 * (1.0 + HASTE)
    assert speed == 0.3 or (away < FAST_AT_ALL and latency > 0.0)
    assert late_speed(0.3, away, latency + 0.1) >= speed >= late_speed(0.3, away + 0.1, latency)
    if away <= FAST_IN_FULL and latency >= 1.0:
        assert speed == 0.3 * (1.0 + HASTE)


SPEED, NORM = 0.1, 0.8
ROBOTS = (RobotSpec(1, 0.04, (0.0, 0.0), (0.05, 0.0)), RobotSpec(2, 0.04, (0.5, 0.0), (-0.5, 0.0)))
SCENARIO = Scenario(ROBOTS, control=Control(k=20.0, speed=SPEED))


def speed(norm: float, farthest: float, late: int = 0) -> float:
    """Of robot 1 in tick 10, m/s; of robot 2 a summary of `late` ticks ago had a slice of `norm` (m), and
    that it was `farthest` (m) from its goal."""
    field = FarField(10 - late)
    field.count, field.largest, field.slice = 1, farthest**2, norm
    neighbours = Neighbours({2: 0.04})
    neighbours.far = field
    law = choose(SCENARIO, 1)
    view = View(10, (0.0, 0.0), (0.05, 0.0), (0.0, 0.0), neighbours)
    return math.hypot(*law.velocity(view))


def test_a_far_robot_may_have_come_closer_to_its_goal_since() -> None:
    way = 2.0 * SPEED * 8 * SCENARIO.time.step
    assert speed(NORM, 4.0, late=8) == pytest.approx(speed(NORM - way, 4.0), rel=1e-9)
    assert speed(NORM, 4.0, late=8) > speed(NORM, 4.0)
