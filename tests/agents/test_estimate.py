"""The estimate: the truth is never farther away than the bound says, and ideal sensing is exact."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.estimate import HISTORY, Disk, Estimate, intersection
from protocol.messages import Measurement

REACH = 0.005
polar = st.tuples(st.floats(0.0, 2.0 * math.pi), st.floats(0.0, 1.0))


def measurement(
    tick: int,
    position: tuple[float, float] | None,
    stamp: int | None = None,
    displacement: tuple[float, float] = (0.0, 0.0),
) -> Measurement:
    return Measurement(1, 1, tick, position, tick if stamp is None else stamp, displacement, (1,))


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
def test_truth_is_within_the_bound(steps, error) -> None:
    estimate = Estimate(error, REACH)
    truth, moved, missed = [(0.1, -0.05)], (0.0, 0.0), False
    for tick, (move, wrong, age, present) in enumerate(steps):
        if present or tick == 0:
            position = None
            if age is not None:
                x, y = truth[max(0, tick - age)]
                ex, ey = off(*wrong, error)
                position = (x + ex, y + ey)
            estimate.update(measurement(tick, position, max(0, tick - (age or 0)), moved))
            if estimate.position is not None:
                assert math.dist(estimate.position, truth[-1]) <= estimate.bound + 1e-12
        missed = not (present or tick == 0)
        moved = (0.0, 0.0) if missed else off(*move, REACH)
        truth.append((truth[-1][0] + moved[0], truth[-1][1] + moved[1]))


@given(st.lists(st.tuples(st.floats(-1, 1), st.floats(-1, 1)), min_size=1, max_size=20))
def test_ideal_sensing_is_bit_identical(points) -> None:
    estimate = Estimate(0.0, REACH)
    before = points[0]
    for tick, point in enumerate(points):
        estimate.update(measurement(tick, point, None, (point[0] - before[0], point[1] - before[1])))
        before = point
        assert estimate.position == point
        assert estimate.bound == 0.0


def test_nothing_is_known_before_the_first_measurement() -> None:
    estimate = Estimate(0.001, REACH)
    estimate.update(measurement(0, None))
    assert not estimate.known
    assert estimate.position is None
    assert estimate.bound == math.inf


def test_odometry_carries_a_delayed_measurement_to_the_present() -> None:
    estimate = Estimate(0.001, REACH)
    for tick in range(5):
        estimate.update(measurement(tick, None, None, (0.002, 0.001)))
    estimate.update(measurement(5, (0.5, 0.5), 2, (0.002, 0.001)))
    assert estimate.position == pytest.approx((0.506, 0.503))
    assert estimate.bound == 0.001


def test_a_measurement_from_before_this_life_is_of_no_use() -> None:
    estimate = Estimate(0.001, REACH)
    estimate.update(measurement(100, (0.1, 0.1), 97))
    assert not estimate.known
    estimate.update(measurement(101, (0.1, 0.1), 100))
    assert estimate.known


def test_a_measurement_older_than_the_history_is_ignored() -> None:
    estimate = Estimate(0.001, REACH)
    for tick in range(HISTORY + 5):
        estimate.update(measurement(tick, None))
    estimate.update(measurement(HISTORY + 5, (0.1, 0.1), 1))
    assert not estimate.known


def test_repeated_noisy_measurements_shrink_the_bound() -> None:
    estimate = Estimate(0.003, REACH)
    for tick in range(40):
        estimate.update(measurement(tick, off(tick * 2.4, 1.0, 0.003)))
    assert estimate.bound < 0.001


def test_missed_odometry_widens_the_bound_by_one_move() -> None:
    estimate = Estimate(0.0, REACH)
    estimate.update(measurement(0, (0.1, 0.1)))
    estimate.update(measurement(4, None))
    assert estimate.bound == REACH


@given(st.floats(0.0, 2.5), st.floats(0.0, 1.0), st.floats(0.0, 1.0), polar, polar)
def test_intersection_covers_what_both_disks_share(distance, r1, r2, where, turn) -> None:
    centre = off(turn[0], 1.0, distance)
    one, other = Disk(0.0, 0.0, r1), Disk(*centre, r2)
    shared = intersection(one, other)
    for disk in (one, other):
        dx, dy = off(where[0], where[1] ** 0.5, disk.radius)
        point = (disk.x + dx, disk.y + dy)
        if all(math.dist(point, (d.x, d.y)) <= d.radius for d in (one, other)):
            assert math.dist(point, (shared.x, shared.y)) <= shared.radius + 1e-9
    if distance <= r1 + r2:
        assert shared.radius <= min(r1, r2) + 1e-9


def test_contradicting_disks_are_both_kept() -> None:
    both = intersection(Disk(0.0, 0.0, 1.0), Disk(5.0, 0.0, 2.0))
    assert (both.x, both.y, both.radius) == pytest.approx((3.0, 0.0, 4.0))
