"""What robots are told of themselves: late and noisy positions; odometry and directions within bounds."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocol.bodies.kinematics import turned
from protocol.scenario.body import Body
from protocol.scenario.model import Scenario, Sensing
from tests.world.driving import STEP, advance, joined, two
from world.plants.plant import BaseReport, truncated_normal
from world.simulation import OdometrySensor, Sensor

TRUTH = (0.123, -0.0456)


def sensor(seed=0, **faults):
    return Sensor(two(seed=seed, sensing=(Sensing(**faults),)), 1)


@given(
    st.integers(0, 2**63 - 1),
    st.floats(1e-6, 0.1),
    st.none() | st.floats(1e-6, 0.2),
    st.tuples(st.floats(-0.05, 0.05), st.floats(-0.05, 0.05)),
)
def test_the_error_of_a_measurement_never_exceeds_its_stated_bound(seed, noise, noise_bound, bias):
    faults = Sensing(noise=noise, noise_bound=noise_bound, bias=bias)
    eye = sensor(seed=seed, noise=noise, noise_bound=noise_bound, bias=bias)
    for tick in range(20):
        position, stamp = eye.measure(tick, TRUTH)
        assert (stamp, eye.bound) == (tick, faults.bound)
        assert math.dist(position, TRUTH) <= faults.bound


def test_truncated_normal_has_the_right_distribution():
    """Against rejection: radius by its empirical distribution, angle by its first two moments."""
    source = np.random.default_rng(3)
    deviation, bound, count = 1.0, 1.5, 20_000
    drawn = np.array([truncated_normal(*pair, deviation, bound) for pair in source.random((count, 2))])
    normal = source.normal(0.0, deviation, (3 * count, 2))
    kept = normal[np.hypot(*normal.T) <= bound][:count]
    radii, expected = np.sort(np.hypot(*drawn.T)), np.sort(np.hypot(*kept.T))
    assert np.abs(radii - expected).max() < 0.04
    assert np.abs(drawn.mean(axis=0)).max() < 0.03
    assert np.allclose(np.cov(drawn.T), np.cov(kept.T), atol=0.03)


@given(
    st.floats(-0.3, 0.3), st.floats(-0.3, 0.3), st.floats(0.0, 1.0, exclude_max=True), st.floats(1e-4, 0.1)
)
def test_the_largest_draw_keeps_its_bound_in_spite_of_rounding(x, y, angular, bound):
    nx, ny = truncated_normal(math.nextafter(1.0, 0.0), angular, 10.0 * bound, bound)
    assert math.hypot((x + nx) - x, (y + ny) - y) <= bound


@pytest.mark.parametrize(("delay", "ticks"), [(STEP, 1), (0.1, 2), (0.11, 3), (0.001, 1), (0.15, 3)])
def test_a_fixed_delay_takes_effect_at_the_first_tick_at_or_after_it(delay, ticks):
    eye = sensor(delay=delay)
    heard = [eye.measure(tick, (float(tick), 0.0)) for tick in range(10)]
    assert heard[:ticks] == [(None, tick) for tick in range(ticks)]
    assert heard[ticks:] == [((float(tick - ticks), 0.0), tick - ticks) for tick in range(ticks, 10)]
    assert (eye.missing, eye.delayed) == (ticks, 10 - ticks)


@given(st.integers(0, 2**40))
def test_random_delays_deliver_the_newest_once_and_never_go_back(seed):
    eye = sensor(seed=seed, delay=(0.0, 0.3))
    newest = -1
    for tick in range(60):
        position, stamp = eye.measure(tick, (float(tick), 0.0))
        if position is None:
            assert stamp == tick
        else:
            assert position == (float(stamp), 0.0)
            assert newest < stamp <= tick
            assert tick - stamp <= 6
            newest = stamp


def test_dropout_loses_its_share():
    eye = sensor(dropout=0.3)
    missing = sum(eye.measure(tick, TRUTH)[0] is None for tick in range(3000))
    assert missing == eye.missing == eye.dropped
    assert 800 < missing < 1000
    nothing = sensor(dropout=1.0)
    assert all(nothing.measure(tick, TRUTH)[0] is None for tick in range(50))


def test_sensing_faults_may_name_robots():
    setting = two(sensing=(Sensing(), Sensing(bias=(0.01, 0.0), robots=(2,))))
    assert Sensor(setting, 1).measure(0, TRUTH) == (TRUTH, 0)
    assert Sensor(setting, 2).measure(0, TRUTH) == ((TRUTH[0] + 0.01, TRUTH[1]), 0)


component = st.floats(-0.1, 0.1)
BASE = Body("omnidirectional", acceleration=0.2, hold=0.2, odometry=0.1, drift=1e-3)


def setting(body: Body = BASE, heading: float = 0.0, seed: int = 0) -> Scenario:
    return replace(two(seed=seed), body=body, sensing=(Sensing(heading=heading),))


@given(component, component, st.floats(1.0, 3.0), st.integers(0, 10**6), st.integers(0, 2**63 - 1))
def test_odometry_is_off_by_no_more_than_it_says(x, y, winding, tick, seed):
    way = winding * math.hypot(x, y)
    report = BaseReport((x, y), way, (0.1, 0.0), 0.3, (0.01, 0.0))
    said, bound, _ = OdometrySensor(setting(seed=seed), 1, slips=False).read(report, tick)
    assert math.dist(said, (x, y)) <= bound
    assert math.dist(said, (x, y)) <= BASE.odometry * way + BASE.drift


@given(component, component, st.integers(0, 10**6))
def test_a_base_takes_commands_in_the_frame_that_it_reports_in(vx, vy, tick):
    odometer = OdometrySensor(setting(heading=0.1), 1, slips=False)
    _, _, motion = odometer.read(BaseReport((0.0, 0.0), 0.0, (0.1, 0.05), 1.0, (0.02, 0.01)), tick)
    askew = motion.heading - 1.0
    assert abs(askew) <= 0.1
    assert motion.velocity == pytest.approx(turned(0.1, 0.05, askew))
    assert motion.stop == pytest.approx(turned(0.02, 0.01, askew))
    assert odometer.obeyed((vx, vy), tick) == pytest.approx(turned(vx, vy, -askew))


@given(component, component, st.integers(0, 10**6))
def test_a_point_goes_where_it_is_told_however_bad_its_odometry_is(vx, vy, tick):
    """Its filter counts on that (`agents/bodies.py`)."""
    odometer = OdometrySensor(setting(Body(odometry=0.1, drift=1e-3), heading=0.1), 1, slips=False)
    assert odometer.obeyed((vx, vy), tick) == (vx, vy)


def test_a_robot_that_still_moves_is_not_announced_as_standing():
    world = joined(setting(replace(BASE, hold=0.3)))
    for _ in range(8):
        advance(world, {1: (0.08, 0.0)})
    world.lost(1)
    moving, quiet = [], 0
    while not world.lives.roster.standing:
        before = world.truth.positions[0]
        advance(world)
        quiet += 1
        moving.append(world.truth.positions[0] != before)
        assert quiet < 40
    silence = world.scenario.ticks(world.scenario.time.fence)
    assert quiet > silence  # a point would have been fenced by then
    assert moving[silence]
    (fenced,) = world.lives.roster.standing
    place = world.truth.positions[0]
    for _ in range(5):
        advance(world)
    assert world.truth.positions[0] == place == fenced.position
