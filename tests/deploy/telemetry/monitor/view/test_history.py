"""What a view keeps of a long run: not all of it, and no minimum is lost."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from deploy.telemetry.monitor import snapshot as telling
from deploy.telemetry.monitor.live import HISTORY
from deploy.telemetry.scene import Thinned
from tests.deploy.telemetry.monitor.view.heard import truth, view


@given(st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=120), st.integers(0, 119))
def test_no_smallest_clearance_is_lost_to_thinning(clearances: list[float], since: int) -> None:
    it = view()
    for tick, clearance in enumerate(clearances, start=1):
        it.on_message(truth(tick, clearance=clearance), tick * 0.001)
    frame = telling.snapshot(it, 1.0, since)
    assert len(frame["samples"]) <= 8
    assert frame["smallest"] == min(clearances)
    if clearances[since:]:
        assert min(sample[2] for sample in frame["samples"]) == min(clearances[since:])
        assert frame["samples"][-1][0] == len(clearances)


@given(st.integers(1, 5000), st.integers(1, 40))
def test_thinned_stays_bounded_and_keeps_order_and_minimum(count: int, limit: int) -> None:
    kept: Thinned[tuple[int, int]] = Thinned(limit, lambda a, b: (b[0], min(a[1], b[1])))
    for n in range(count):
        kept.append((n, (n * 7919) % 1000))
    assert 1 <= len(kept.items) <= limit + 1
    assert [n for n, _ in kept.items] == sorted(n for n, _ in kept.items)
    assert kept.items[-1][0] == count - 1
    assert min(value for _, value in kept.items) == min((n * 7919) % 1000 for n in range(count))


def test_the_history_of_a_long_run_stays_bounded() -> None:
    it = view()
    for tick in range(1, 5 * HISTORY):
        it.on_message(truth(tick), 0.0)
    told = telling.overview(it)
    assert len(told["history"]) <= HISTORY
    assert told["history"][-1][0] == pytest.approx((5 * HISTORY - 1) * 0.05)
    assert all(len(robot["trail"]) <= 5000 for robot in told["robots"])
