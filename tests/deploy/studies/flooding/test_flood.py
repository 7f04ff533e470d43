"""Floods: what they are made of, what is judged, and a short one with and without access rules."""

from __future__ import annotations

from typing import Any

import pytest

from deploy.run.fleet import ENOUGH
from deploy.studies.flooding.flood import Flooding, Plan, flood, result
from deploy.studies.flooding.flooder import Flooded
from deploy.studies.flooding.garbage import garbage
from deploy.studies.flooding.intervals import SETTLING, Intervals
from protocol.errors import MessageError
from protocol.messages import State
from protocol.wire.codec import decode

PLAN = Plan(10_000.0, 6, 2, 1.0, secure=True)


def report(**changes: Any) -> dict[str, Any]:
    usual = {"reason": "", "collisions": 0, "messages": {"rejected": {}}, "trajectory_sha256": "a"}
    return usual | changes


REPORTS = [report(), report(trajectory_sha256="b"), report(), report(reason=ENOUGH, trajectory_sha256="c")]
FLOODS = [Flooded(10_000, 1.0), Flooded(9_990, 1.0)]


def failures(outcome: dict[str, Any]) -> list[str]:
    return [each["what"] for each in outcome["criteria"] if each["holds"] is False]


def test_nothing_in_a_flood_is_a_message_of_the_fleet() -> None:
    reasons = set()
    messages = garbage("yard", (1, 2, 3))
    for key, payload in messages:
        assert key.startswith("disknav/yard/")
        try:
            accepted = decode(key, payload)
        except MessageError as error:
            reasons.add(error.reason)
        else:
            assert isinstance(accepted, State)
            assert accepted.robot not in (1, 2, 3)
    assert reasons == {"shape", "oversize", "key"}
    assert messages == garbage("yard", (1, 2, 3))


def test_stretches_leave_out_what_settles_and_changes_of_runs() -> None:
    intervals = Intervals(1.0)
    ended = []
    turn, tick = 0, 0
    for n in range(60):
        now = n * 0.05
        tick += 5 if now >= SETTLING else 100
        if n == 12:
            turn, tick = 1, 0
        ended.append(intervals.on_clock(now, turn, tick))
    assert ended.count(True) == 2
    assert intervals.rates[0] == pytest.approx(100.0)


def test_a_flood_that_nobody_notices() -> None:
    outcome = result(PLAN, [100.0, 90.0, 100.0, 85.0], FLOODS, REPORTS)
    assert outcome["slower"] == pytest.approx(0.125)
    assert outcome["passed"]


@pytest.mark.parametrize(
    ("rates", "floods", "reports", "what"),
    [
        ([100.0, 70.0], FLOODS, REPORTS, "at most 20% slower"),
        ([], FLOODS, REPORTS, "at most 20% slower"),
        ([100.0, 90.0], [Flooded(5000, 1.0)], REPORTS, "flooded as asked"),
        ([100.0, 90.0], FLOODS, [report(collisions=1), *REPORTS[1:]], "nothing touched"),
        ([100.0, 90.0], FLOODS, [*REPORTS[:2], report(trajectory_sha256="x"), REPORTS[3]],
         "the same trajectories"),
        ([100.0, 90.0], FLOODS, [report(messages={"rejected": {"shape": 1}}), *REPORTS[1:]],
         "nothing got past the router"),
    ],
)  # fmt: skip
def test_a_flood_that_does_harm(rates: Any, floods: Any, reports: Any, what: str) -> None:
    outcome = result(PLAN, rates, floods, reports)
    assert not outcome["passed"]
    assert failures(outcome) == [what]


def test_without_rules_the_rate_is_reported_and_rejections_are_due() -> None:
    unprotected = Plan(10_000.0, 6, 2, 1.0, secure=False)
    assert failures(result(unprotected, [100.0, 10.0], FLOODS, REPORTS)) == [
        "receivers counted what they rejected"
    ]


@pytest.mark.process
@pytest.mark.timeout(90)
@pytest.mark.parametrize("role", ["monitor", "robot", None])
def test_a_short_flood(role: Flooding | None) -> None:
    """How fast it was is for a quiet machine to say."""
    if role:
        pytest.importorskip("cryptography")
    told: list[float] = []
    outcome = flood(Plan(500.0, 3, 1, 1.0, role is not None, role or "monitor"), told.append)
    assert set(failures(outcome)) <= {"flooded as asked", "at most 20% slower"}
    assert told[-1] == 1.0
    assert outcome["sent"] > 0
    assert len(outcome["ticks_per_second"]["flooded"]) == 1
    assert bool(outcome["rejected"]) is (role != "monitor")
