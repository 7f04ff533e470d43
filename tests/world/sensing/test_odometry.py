"""What a base says of itself is off by no more than it states, and everything by the same direction."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocol.bodies.kinematics import turned
from protocol.scenario.body import Body
from protocol.scenario.model import Scenario, Sensing
from tests.world.driving import advance, joined, two
from world.plants.plant import Report
from world.sensing.odometry import Odometer

component = st.floats(-0.1, 0.1)
BASE = Body("omnidirectional", acceleration=0.2, hold=0.2, odometry=0.1, drift=1e-3)


def setting(body: Body = BASE, heading: float = 0.0, seed: int = 0) -> Scenario:
    return replace(two(seed=seed), body=body, sensing=(Sensing(heading=heading),))


@given(component, component, st.floats(1.0, 3.0), st.integers(0, 10**6), st.integers(0, 2**63 - 1))
def test_odometry_is_off_by_no_more_than_it_says(x, y, winding, tick, seed):
    way = winding * math.hypot(x, y)
    report = Report((x, y), way, (0.1, 0.0), 0.3, (0.01, 0.0))
    said, bound, _ = Odometer(setting(seed=seed), 1, slips=False).read(report, tick)
    assert math.dist(said, (x, y)) <= bound
    assert math.dist(said, (x, y)) <= BASE.odometry * way + BASE.drift


@given(component, component, st.integers(0, 10**6))
def test_a_base_takes_commands_in_the_frame_that_it_reports_in(vx, vy, tick):
    odometer = Odometer(setting(heading=0.1), 1, slips=False)
    _, _, motion = odometer.read(Report((0.0, 0.0), 0.0, (0.1, 0.05), 1.0, (0.02, 0.01)), tick)
    assert motion is not None
    askew = motion.heading - 1.0
    assert abs(askew) <= 0.1
    assert motion.velocity == pytest.approx(turned(0.1, 0.05, askew))
    assert motion.stop == pytest.approx(turned(0.02, 0.01, askew))
    assert odometer.obeyed((vx, vy), tick) == pytest.approx(turned(vx, vy, -askew))


def test_a_point_says_what_it_did_and_nothing_else():
    odometer = Odometer(two(), 1, slips=False)
    assert odometer.read(Report((0.1, 0.2), math.hypot(0.1, 0.2)), 3) == ((0.1, 0.2), 0.0, None)
    assert odometer.obeyed((0.1, 0.2), 3) == (0.1, 0.2)


@given(component, component, st.integers(0, 10**6))
def test_a_point_goes_where_it_is_told_however_bad_its_odometry_is(vx, vy, tick):
    """Its filter counts on that (`agents/bodies/body.py`)."""
    odometer = Odometer(setting(Body(odometry=0.1, drift=1e-3), heading=0.1), 1, slips=False)
    assert odometer.obeyed((vx, vy), tick) == (vx, vy)


def test_a_robot_that_still_moves_is_not_announced_as_standing():
    world = joined(setting(replace(BASE, hold=0.3)))
    for _ in range(8):
        advance(world, {1: (0.08, 0.0)})
    world.coordinator.lost(1)
    moving, quiet = [], 0
    while not world.coordinator.lives.standing:
        before = world.truth.positions[0]
        advance(world)
        quiet += 1
        moving.append(world.truth.positions[0] != before)
        assert quiet < 40
    silence = world.scenario.ticks(world.scenario.time.fence)
    assert quiet > silence  # a point would have been fenced by then
    assert moving[silence]
    (fenced,) = world.coordinator.lives.standing
    place = world.truth.positions[0]
    for _ in range(5):
        advance(world)
    assert world.truth.positions[0] == place == fenced.position
