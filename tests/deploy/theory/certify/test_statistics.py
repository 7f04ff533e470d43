"""Clopper and Pearson's bound, and the failing fraction of figure 2 on both sides of its threshold."""

from __future__ import annotations

from dataclasses import replace

import pytest

from deploy.theory.exact_flow import failing_fraction, upper_bound
from tests.deploy.theory.certify.known import blockade


@pytest.mark.slow
@pytest.mark.parametrize(("starts", "bound"), [(300, 0.01), (3000, 0.001)])
def test_no_failure_bounds_the_fraction(starts: int, bound: float) -> None:
    assert 0.99 * bound < upper_bound(0, starts) < bound
    assert upper_bound(0, starts) == pytest.approx(1.0 - 0.05 ** (1.0 / starts))


def test_the_bound_is_where_so_few_failures_have_probability_five_percent() -> None:
    q = upper_bound(1, 20)
    assert (1 - q) ** 20 + 20 * q * (1 - q) ** 19 == pytest.approx(0.05)
    assert upper_bound(20, 20) == 1.0


@pytest.mark.parametrize(("k", "fails"), [(2.2, True), (60.0, False)])
def test_figure_2_fails_below_its_threshold_and_not_above(k: float, fails: bool) -> None:
    problem = blockade(2.2).problem
    found = failing_fraction(replace(problem, k=k), 6, 1, print)
    assert (found.failed > 0) == fails
    assert found.at_most > found.failed / found.starts
    assert "no proof" in str(found)
