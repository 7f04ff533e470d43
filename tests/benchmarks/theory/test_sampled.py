"""The sampled fleet against the exact flow at the same pace."""

from __future__ import annotations

import pytest

from tests.benchmarks.theory.sampled import PACES, Pace, Pair, row, sampled_study


@pytest.mark.parametrize("pace", PACES)
def test_only_starts_at_which_both_arrive_are_compared(pace: Pace) -> None:
    found = row("d", pace, [Pair(1.1, 1.0), Pair(1.3, 1.0), Pair(None, 1.2), Pair(1.2, None)])
    assert (found.runs, found.compared, found.tight) == (4, 2, 3.30)
    assert found.ratio == pytest.approx(1.2)
    assert found.largest == pytest.approx(1.3)
    assert row("d", pace, [Pair(None, 1.0)]).ratio is None


@pytest.mark.slow
def test_at_50_ms_the_fleet_keeps_to_the_path_of_the_flow() -> None:
    for found in sampled_study("b", runs=3):
        assert found.compared == 3
        assert found.ratio == pytest.approx(1.0, abs=0.05)
