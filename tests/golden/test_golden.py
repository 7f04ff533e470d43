"""Trajectories are those that are kept: within a tolerance on every machine, to the last bit on one like it.

`make golden` renews them, for a change that is meant to move them.
"""

from dataclasses import replace

import pytest

from tests.golden import kept
from tests.golden.__main__ import change
from tests.golden.cases import CASES, LONG, SADDLES
from tests.golden.trajectory import rounding, run

TOLERANCE = 1e-5  # m: far above what another order of additions does, far below what a path may change by
KEPT = kept.read()


def test_every_case_is_kept() -> None:
    assert list(KEPT) == list(CASES)


@pytest.mark.slow
@pytest.mark.parametrize(
    "case", [pytest.param(case, marks=pytest.mark.slow if case in LONG else ()) for case in CASES]
)
def test_a_trajectory_is_the_kept_one(case: str) -> None:
    found, golden = run(CASES[case]()), KEPT[case]
    if case not in SADDLES:
        assert found.deviation(golden) < TOLERANCE
        assert abs(found.ticks - golden.ticks) <= 1  # a last bit may decide when the last robot is there
    if kept.rounding_of_hashes() == rounding():
        assert found.sha256 == golden.sha256, change(case, golden, found)


@pytest.mark.campaign
@pytest.mark.parametrize("case", sorted(CASES.keys() - SADDLES))
def test_a_last_bit_does_not_decide(case: str) -> None:
    """Else comparing within a tolerance would be idle: such a case belongs to the saddles."""
    scenario = CASES[case]()
    first, *others = scenario.robots
    nudged = replace(first, start=(first.start[0] + 1e-15, first.start[1]))
    assert run(replace(scenario, robots=(nudged, *others))).deviation(KEPT[case]) < 0.1 * TOLERANCE


@pytest.mark.slow
@pytest.mark.parametrize("case", ["figure-1", "random-6"])
def test_a_small_numerical_change_is_seen(case: str) -> None:
    """A thousandth in k, say: no test of arrival or clearance would see it."""
    scenario = CASES[case]()
    control = replace(scenario.control, k=1.001 * scenario.k)
    assert run(replace(scenario, control=control)).deviation(KEPT[case]) > TOLERANCE
