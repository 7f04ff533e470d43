"""Reports as a launcher takes them: one a run, and nothing else."""

from __future__ import annotations

import json

import pytest

from deploy.library.load import load
from deploy.run.outcome.reports import Report, Reports
from deploy.run.outcome.unjudged import unjudged
from protocol.errors import MessageError

SWAP = load("swap-2")


def told(run: object, verdict: str, reason: str = "so") -> str:
    return json.dumps(unjudged(SWAP, None, 0.0) | {"run_number": run, "verdict": verdict, "reason": reason})


@pytest.mark.parametrize(
    "report",
    [
        *("", "[]", "{}", "3", "[" * 100_000, '{"verdict": "arrived"}', json.dumps({"verdict": [1]})),
        *(told(run, "arrived") for run in (-1, 2, 0.0, True, "0", None, [0])),
    ],
)
def test_a_launcher_takes_no_report_that_is_none(report: str) -> None:
    reports = Reports(2)
    with pytest.raises(MessageError, match=r"result: (there is no run|the report)"):
        reports.add(report)
    assert reports.all == []


def test_what_is_told_twice_is_one_report_of_each_run_in_their_order() -> None:
    heard: list[Report] = []
    reports = Reports(2, heard.append)
    for run, verdict in ((1, "arrived"), (0, "timeout"), (1, "collision")):
        reports.add(told(run, verdict))
    assert [(report["run_number"], report["verdict"]) for report in reports.all] == [
        (0, "timeout"),
        (1, "arrived"),
    ]
    assert [report["run_number"] for report in heard] == [1, 0]


def test_whose_run_failed_once_certificates_had_ended_is_told_so() -> None:
    """It is a matter of milliseconds whether the world gives up its robots first, or is cut off itself; and
    of the scenario what it makes of a fleet that stands."""
    reports = Reports(4, expired=lambda: "; they ended")
    for run, verdict in enumerate(("aborted", "deadlock", "arrived")):
        reports.add(told(run, verdict))
    reports.add(told(3, "timeout", ""))
    reasons = ["so; they ended", "so; they ended", "so", "they ended"]
    assert [report["reason"] for report in reports.all] == reasons
