"""What a launcher takes for a report, and what the exit status says of a result."""

import json

import pytest

from deploy.library.load import load
from deploy.run.execute import _show
from deploy.run.result import exit_status, kept_status, read_report
from protocol.errors import MessageError
from world.shell.run import JudgedRun


@pytest.mark.parametrize(
    "report", ["", "[]", "{}", "3", "[" * 100_000, '{"verdict": "arrived"}', json.dumps({"verdict": [1]})]
)
def test_a_launcher_takes_no_report_that_is_none(report: str) -> None:
    with pytest.raises(MessageError, match="result: the report"):
        read_report(report)


@pytest.mark.parametrize(("verdict", "collisions", "status"), [("aborted", 0, 3), ("collision", 1, 1)])
def test_a_kept_fleet_does_not_end_well_by_itself(verdict: str, collisions: int, status: int) -> None:
    assert kept_status({"verdict": verdict, "collisions": collisions}) == status


@pytest.mark.parametrize(
    ("verdict", "ticks", "status"),
    [("arrived", 9, 0), ("timeout", 9, 1), ("aborted", 9, 1), ("aborted", 0, 3)],
)
def test_what_never_began_is_a_fault(verdict: str, ticks: int, status: int) -> None:
    assert exit_status({"verdict": verdict, "ticks": ticks}) == status


@pytest.mark.parametrize(("endless", "words"), [("false", " of at most 9 s"), ("true", "")])
def test_progress_tells_when_a_run_ends_at_the_latest(endless: str, words: str) -> None:
    scenario, said = load("swap-2", ["time.limit=9", f"time.endless={endless}"]), list[str]()
    _show(scenario, lambda _, text: said.append(text), JudgedRun(scenario).clock())
    assert said[0].startswith(f"swap-2  t = 0.00 s{words}  gap ")
