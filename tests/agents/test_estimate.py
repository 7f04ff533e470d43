"""The estimate: the truth is always in the set, the set is small, and ideal sensing is exact."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.estimate import Estimate
from agents.lines.own_set import SIDES
from protocol.line import ROUNDING, HalfPlane
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


@pytest.mark.parametrize("bound", [0.0, 0.001])
@pytest.mark.parametrize(
    ("ticks", "stamp", "coasts", "motions"),
    [(5, 2, False, 0), (2, 1, False, 1), (2, 2, False, 0), (2, 2, True, 2), (2, 3, True, 1), (2, 4, True, 0)],
)
def test_odometry_carries_a_delayed_measurement_to_the_present(bound, ticks, stamp, coasts, motions) -> None:
    """Of missed ticks the first is off by one motion, and those in which it may coast, too."""
    estimate = Estimate(REACH, coasts=coasts)
    for tick in range(ticks):
        tell(estimate, bound, tick, None, None, (0.002, 0.001))
    tell(estimate, bound, 5, (0.5, 0.5), stamp, (0.002, 0.001))
    moves = max(1, ticks - stamp)
    assert estimate.position == pytest.approx((0.5 + 0.002 * moves, 0.5 + 0.001 * moves))
    assert bound + motions * REACH <= estimate.bound <= 1.02 * (bound + motions * REACH)


@pytest.mark.parametrize("age", [0, 300])
def test_far_from_the_origin_the_set_grows_by_what_additions_lose(age: int) -> None:
    """Of a step just less than half a unit in the last place every tick loses all, however late it is."""
    estimate, at, step = Estimate(REACH, oldest=300), -99999.0, -0.49 * math.ulp(99999.0)
    tell(estimate, 0.001, 0, (at, at) if age == 0 else None)
    for tick in range(1, 300):
        tell(estimate, 0.001, tick, None, None, (step, step))
    tell(estimate, 0.001, 300, None if age == 0 else (at, at), 0, (step, step))
    lost = 300 * -step - (at - estimate.x)
    assert ROUNDING < lost < estimate.shape.extent(0.0, -1.0) - 0.001
    assert estimate.bound == estimate.shape.radius


@pytest.mark.parametrize("stamp", [97, 101])
def test_a_measurement_from_before_this_life_or_of_a_later_tick_is_of_no_use(stamp: int) -> None:
    estimate = Estimate(REACH)
    tell(estimate, 0.001, 100, (0.1, 0.1), stamp)
    assert estimate.position is None
    tell(estimate, 0.001, 101, (0.1, 0.1), 100)
    assert estimate.position is not None


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
    assert estimate.bound == estimate.shape.radius


@pytest.mark.parametrize(("first", "second"), [(0.0, 0.003), (0.003, 0.0), (0.0, 0.0)])
@pytest.mark.parametrize("far", [0.00294, 0.00588])
@pytest.mark.parametrize("turn", range(8))
def test_an_exact_place_is_kept_and_excludes_what_it_is_not_within(first, second, far, turn) -> None:
    estimate, (x, y) = Estimate(REACH), off(turn * math.pi / 4.0, far, 1.0)
    tell(estimate, first, 7, (0.1, 0.2))
    tell(estimate, second, 8, (0.1 + x, 0.2 + y))
    gap = far - first - second
    if gap > 0.0:
        assert (
            f"tick 8 and the measurement of tick 7 exclude each other by {gap:.2g}" in estimate.contradiction
        )
    else:
        exact = (0.1, 0.2) if first == 0.0 else (0.1 + x, 0.2 + y)
        assert (estimate.contradiction, estimate.position, estimate.bound) == ("", exact, 0.0)
        tell(estimate, 0.0, 9, (exact[0], exact[1] + 1e-4))
        assert estimate.lost


# -- stated bounds that are wrong


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize(("last", "other"), [(0.109, 0), (0.095, 1)])
def test_measurements_that_exclude_each_other_are_named_and_the_rest_ignored(axis, last, other) -> None:
    places = [((x, 0.0), (0.0, x))[axis] for x in (0.1, 0.104, last)]
    estimate = disks(places, 0.003)
    text = f"tick 2 and the measurement of tick {other} exclude each other by 0.003 m"
    assert text in estimate.contradiction
    assert estimate.lost
    before = estimate.position
    assert before[axis] == pytest.approx(0.102)
    tell(estimate, 0.003, 3, (0.105, 0.0))
    assert not estimate.confine(HalfPlane(1.0, 0.0, -1.0), "a wall")
    assert (estimate.position, text in estimate.contradiction) == (before, True)


def test_a_robot_that_may_begins_anew_from_the_newest() -> None:
    estimate = Estimate(REACH, trusting=True)
    for tick, x in enumerate((0.1, 0.107, 0.108)):
        tell(estimate, 0.003, tick, (x, 0.0))
    assert estimate.contradiction
    assert not estimate.lost
    assert estimate.position == pytest.approx((0.1075, 0.0), abs=1e-4)


@pytest.mark.parametrize(("ny", "limit", "other"), [(1.0, -0.005, 1), (-1.0, -0.009, 0)])
def test_a_line_that_the_set_is_wholly_beyond_refutes_the_bounds(ny, limit, other) -> None:
    estimate = disks([(0.1, 0.0), (0.1, 0.004)], 0.003)
    assert not estimate.confine(HalfPlane(0.0, ny, limit), "the line with robot 2")
    assert estimate.contradiction.startswith(f"the line with robot 2 and the measurement of tick {other}")
    assert "by 0.006 m" in estimate.contradiction
    assert estimate.lost
