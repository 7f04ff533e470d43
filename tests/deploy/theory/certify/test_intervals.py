"""Every operation holds the exact result, in rational arithmetic, and is no wider than it must be."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deploy.theory.certify import boxes as i
from deploy.theory.certify.boxes import Interval, derived, narrow, scene_of, whole
from deploy.theory.certify.curvature import stiffness
from deploy.theory.certify.search import solve_into
from tests.deploy.theory.certify.known import known

numbers = st.floats(-1e6, 1e6, allow_subnormal=False)
ordered = st.tuples(numbers, numbers).map(lambda pair: (min(pair), max(pair)))
shares = st.fractions(0, 1)


def inside(a: Interval, share: Fraction) -> Fraction:
    return Fraction(a[0]) + share * (Fraction(a[1]) - Fraction(a[0]))


def holds(a: Interval, x: Fraction) -> bool:
    return bool(Fraction(a[0]) <= x <= Fraction(a[1]))


@given(numbers)
def test_down_and_up_reach_beyond_the_neighbours(x: float) -> None:
    assert i.down(x) <= math.nextafter(x, -math.inf)
    assert i.up(x) >= math.nextafter(x, math.inf)
    assert i.up(x) - i.down(x) <= 1e-15 * abs(x) + 1e-299
    assert i.up(math.inf) == math.inf
    assert i.down(-math.inf) == -math.inf


def test_where_no_folder_can_be_written_nothing_is_cached(monkeypatch: pytest.MonkeyPatch) -> None:
    def nowhere(_: object) -> None:
        raise RuntimeError("cannot cache function 'down': no locator available")

    monkeypatch.setattr("numba.core.dispatcher.FunctionCache", nowhere)
    assert i.compiled(lambda x: x + 1.0)(1.0) == 2.0


@given(ordered, ordered, shares, shares)
@settings(max_examples=400)
@pytest.mark.slow
def test_operations_hold_the_exact_result(a: Interval, b: Interval, s: Fraction, t: Fraction) -> None:
    x, y = inside(a, s), inside(b, t)
    assert holds(i.add(a, b), x + y)
    assert holds(i.sub(a, b), x - y)
    assert holds(i.mul(a, b), x * y)
    assert holds(i.square(a), x * x)
    assert a[0] <= i.middle(a) <= a[1]
    if a[0] >= 0.0:
        assert holds(i.weigh(a, b), x * y)
        assert Fraction(i.root_below(a[0])) ** 2 <= Fraction(a[0]) <= Fraction(i.root_above(a[0])) ** 2
    if not b[0] <= 0.0 <= b[1] and min(abs(b[0]), abs(b[1])) > 1e-6:
        assert holds(i.divide(a, b), x / y)


@given(ordered, shares, st.floats(0.0, 1e6))
def test_an_unbounded_weight_is_never_nan(b: Interval, share: Fraction, low: float) -> None:
    found = i.weigh((low, math.inf), b)
    x = inside(b, share)
    assert not math.isnan(found[0])
    assert not math.isnan(found[1])
    assert found[0] <= float(x * 2 * Fraction(low)) or x >= 0
    assert (found[1] == math.inf) == (b[1] > 0.0)
    assert (found[0] == -math.inf) == (b[0] < 0.0)


def test_bounds_that_are_no_number_or_overflowed_exclude_nothing() -> None:
    row = np.array([[0.0, 1.0]])
    assert narrow(row, 0, (math.nan, math.nan))
    assert row.tolist() == [[0.0, 1.0]]
    row[0, 1] = math.inf
    assert narrow(row, 0, (math.inf, math.inf))
    assert row[0, 0] < math.inf == row[0, 1]


@pytest.mark.slow
@pytest.mark.parametrize(
    "entries", [(1.0, 1.0, 1.0, 1.0), (1e-120, 0.0, 0.0, 1.0), (math.nan, 0.0, 0.0, 1.0)]
)
def test_matrices_that_are_as_good_as_singular_have_no_inverse(entries: tuple[float, ...]) -> None:
    assert not solve_into(np.array(entries).reshape(2, 2), np.empty((2, 2)))


def test_the_stiffness_of_a_contact_that_is_almost_closed_is_not_negative() -> None:
    found = known(0)[0]
    scene = scene_of(found.problem)
    out, n = derived(scene), 2 * found.problem.p
    box = whole(scene, (0.0, 1.0))
    box[n:-1, 1] = 1e300
    out.total[1], out.beta[:, 0] = (0.0, 1.0), 1e-200
    assert all(stiffness(box, out, n, q) > 1e199 for q in range(len(scene.first)))
