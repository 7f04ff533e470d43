"""At the common pace a robot goes by far ones as well, by what the last summary says of their slices."""

from __future__ import annotations

import math

import pytest

from agents.laws import View, choose
from agents.navigation.far_field import FarField
from agents.peers.neighbours import Neighbours
from protocol.scenario.model import Control, RobotSpec, Scenario

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
    view = View(
        tick=10, position=(0.0, 0.0), goal=(0.05, 0.0), displacement=(0.0, 0.0), neighbours=neighbours
    )
    return math.hypot(*law.velocity(view))


def test_twice_the_slice_is_half_the_speed() -> None:
    assert speed(2.0 * NORM, 4.0) == pytest.approx(0.5 * speed(NORM, 4.0), rel=1e-2)


def test_it_is_as_slow_as_the_attraction_at_most() -> None:
    assert speed(50.0, 0.5 * NORM) == pytest.approx(speed(NORM, 4.0), rel=1e-9)


def test_a_far_robot_may_have_come_closer_to_its_goal_since() -> None:
    way = 2.0 * SPEED * 8 * SCENARIO.time.step
    assert speed(NORM, 4.0, late=8) == pytest.approx(speed(NORM - way, 4.0), rel=1e-9)
    assert speed(NORM, 4.0, late=8) > speed(NORM, 4.0)
