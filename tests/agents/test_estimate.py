"""The estimate: the truth is always in the set, the set is small, and ideal sensing is exact."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.estimate import HISTORY, Estimate
from agents.lines.own_set import SIDES
from protocol.line import HalfPlane
from protocol.messages import Sense, Vector

REACH = 0.005
polar = st.tuples(st.floats(0.0, 2.0 * math.pi), st.floats(0.0, 1.0))


def support(estimate: Estimate, nx: float, ny: float) -> float:
    """The largest n.x of any place x where the robot can be, m."""
    extent = estimate.bound if estimate.shape is None else estimate.shape.extent(nx, ny)
    return nx * estimate.x + ny * estimate.y + extent


def tell(
    estimate: Estimate, bound: float, tick: int, at: Vector | None, stamp: int | None = None, moved=(0.0, 0.0)
) -> None:
    estimate.update(tick, Sense(at, tick if stamp is None else stamp, bound, moved))


def off(angle: float, share: float, size: float) -> tuple[float, float]:
    return size * share * math.cos(angle), size * share * math.sin(angle)


ticks = st.lists(
    st.tuples(
        polar,  # what is executed
        polar,  # the measurement's error
        st.one_of(st.none(), st.integers(0, 12)),  # its age; None: missing
        st.booleans(),  # whether the robot takes part in the tick
    ),
    min_size=1,
    max_size=60,
)


@given(ticks, st.sampled_from([0.0, 1e-6, 0.003, 0.05]))
def test_truth_is_in_the_set(steps, error) -> None:
    estimate = Estimate(REACH)
    truth, moved, missed = [(0.1, -0.05)], (0.0, 0.0), False
    for tick, (move, wrong, age, present) in enumerate(steps):
        if present or tick == 0:
            position = None
            if age is not None:
                x, y = truth[max(0, tick - age)]
                ex, ey = off(*wrong, error)
                position = (x + ex, y + ey)
            tell(estimate, error, tick, position, max(0, tick - (age or 0)), moved)
            assert estimate.contradiction == ""
            if estimate.position is not None:
                assert math.dist(estimate.position, truth[-1]) <= estimate.bound + 1e-12
                for direction in range(40):
                    nx, ny = off(direction * math.pi / 20.0, 1.0, 1.0)
                    assert nx * truth[-1][0] + ny * truth[-1][1] <= support(estimate, nx, ny) + 1e-12
        missed = not (present or tick == 0)
        moved = (0.0, 0.0) if missed else off(*move, REACH)
        truth.append((truth[-1][0] + moved[0], truth[-1][1] + moved[1]))


@given(st.lists(st.tuples(st.floats(-1, 1), st.floats(-1, 1)), min_size=1, max_size=20))
def test_ideal_sensing_is_bit_identical(points) -> None:
    estimate = Estimate(REACH)
    before = points[0]
    for tick, point in enumerate(points):
        tell(estimate, 0.0, tick, point, None, (point[0] - before[0], point[1] - before[1]))
        before = point
        assert estimate.position == point
        assert estimate.bound == 0.0


def test_odometry_carries_a_delayed_measurement_to_the_present() -> None:
    estimate = Estimate(REACH)
    for tick in range(5):
        tell(estimate, 0.001, tick, None, None, (0.002, 0.001))
    tell(estimate, 0.001, 5, (0.5, 0.5), 2, (0.002, 0.001))
    assert estimate.position == pytest.approx((0.506, 0.503))
    assert estimate.bound == pytest.approx(0.001, rel=0.02)


def test_a_measurement_of_before_some_missed_ticks_is_off_by_one_motion_more() -> None:
    estimate = Estimate(REACH)
    for tick in (0, 1):
        tell(estimate, 0.001, tick, None)
    tell(estimate, 0.001, 5, (0.5, 0.5), 1, (0.002, 0.001))
    assert estimate.position == pytest.approx((0.502, 0.501))
    assert estimate.bound == pytest.approx(0.001 + REACH, rel=0.02)


def test_a_measurement_from_before_this_life_is_of_no_use() -> None:
    estimate = Estimate(REACH)
    tell(estimate, 0.001, 100, (0.1, 0.1), 97)
    assert estimate.position is None
    tell(estimate, 0.001, 101, (0.1, 0.1), 100)
    assert estimate.position is not None


def test_however_late_measurements_may_come_odometry_is_kept_for_as_long() -> None:
    estimate = Estimate(REACH, oldest=5 * HISTORY)
    for tick in range(5 * HISTORY + 1):
        tell(estimate, 0.001, tick, None)
    tell(estimate, 0.001, 5 * HISTORY + 1, (0.1, 0.1), 1)
    assert estimate.position == pytest.approx((0.1, 0.1))


def disks(points: list[tuple[float, float]], error: float) -> Estimate:
    estimate = Estimate(REACH)
    for tick, point in enumerate(points):
        tell(estimate, error, tick, point)
    return estimate


@given(st.lists(polar, min_size=1, max_size=12), st.floats(0.0, 2.0 * math.pi))
def test_the_set_is_what_all_measurements_share_up_to_the_corners_of_the_polygon(wrong, angle) -> None:
    """Never wider than the narrowest of them, and exact in the fixed directions of two that differ."""
    points = [off(*each, 0.003) for each in wrong]
    estimate = disks(points, 0.003)
    nx, ny = off(angle, 1.0, 1.0)
    widest = 0.003 / math.cos(math.pi / SIDES) + 1e-8
    assert support(estimate, nx, ny) <= min(nx * x + ny * y for x, y in points) + widest
    assert estimate.bound <= 0.003 * 1.02**2 + 1e-8


def test_what_else_is_known_cuts_the_set() -> None:
    estimate = disks([(0.1, 0.0)], 0.003)
    assert estimate.confine(HalfPlane(1.0, 0.0, 0.099), "the workspace")
    assert not estimate.confine(HalfPlane(1.0, 0.0, 0.099), "the workspace")
    assert support(estimate, 1.0, 0.0) == pytest.approx(0.099, abs=1e-8)
    assert support(estimate, -1.0, 0.0) == pytest.approx(-0.097, abs=1e-8)
    assert estimate.position[0] == pytest.approx(0.098)
    assert not estimate.contradiction


# -- stated bounds that are wrong


def test_measurements_that_exclude_each_other_are_named_and_the_rest_ignored() -> None:
    estimate = disks([(0.1, 0.0), (0.1, 0.0), (0.107, 0.0)], 0.003)
    assert "tick 2 and the measurement of tick 0 exclude each other by 0.001 m" in estimate.contradiction
    assert estimate.lost
    tell(estimate, 0.003, 3, (0.105, 0.0))
    assert estimate.position == (0.1, 0.0)


def test_a_robot_that_may_begins_anew_from_the_newest() -> None:
    estimate = Estimate(REACH, trusting=True)
    for tick, x in enumerate((0.1, 0.107, 0.108)):
        tell(estimate, 0.003, tick, (x, 0.0))
    assert estimate.contradiction
    assert not estimate.lost
    assert estimate.position == pytest.approx((0.1075, 0.0), abs=1e-4)


def test_a_line_that_the_set_is_wholly_beyond_refutes_the_bounds() -> None:
    estimate = disks([(0.1, 0.0)], 0.003)
    assert not estimate.confine(HalfPlane(1.0, 0.0, 0.09), "the line with robot 2")
    assert estimate.contradiction.startswith("the line with robot 2 and the measurement of tick 0")
    assert estimate.lost
