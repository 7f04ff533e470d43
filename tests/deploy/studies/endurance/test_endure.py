"""A trial of endurance: what it judges, and a short one on real processes."""

from __future__ import annotations

import json
import subprocess
import sys
from array import array
from itertools import pairwise
from math import dist
from typing import Any

import pytest

from deploy.run.fleet import ENOUGH
from deploy.run.options import RunOptions
from deploy.studies.endurance.judgement import passed
from deploy.studies.endurance.observation import LAUNCHER
from deploy.studies.endurance.outcome import result
from deploy.studies.endurance.samples import Samples
from deploy.studies.endurance.trial import Trial
from deploy.studies.endurance.workload import workload
from protocol.scenario.file import validated

TRIAL = Trial(2, 1.0, RunOptions(mode="realtime"))


def report(**changes: Any) -> dict[str, Any]:
    usual = {"verdict": "arrived", "reason": "", "ticks": 200, "wall_time": 10.0, "missed_commands": 0}
    return usual | {"collisions": 0} | changes


LAST = report(verdict="interrupted", reason=ENOUGH)


def samples(handles: list[float], megabytes: float = 0.0) -> Samples:
    """Ten samples of one process whose memory rises by `megabytes` from one to the next."""
    count = range(len(handles))
    series = {name: array("d", [7.0] * len(handles)) for name in ("private_mb", "resident_mb", "threads")}
    series |= {
        "time": array("d", count),
        "pid": array("d", [1.0] * len(handles)),
        "handles": array("d", handles),
    }
    series["anonymous_mb"] = array("d", [5.0 + megabytes * n for n in count])
    return Samples(1.0, {"robot-1": series})


def failures(outcome: dict[str, Any]) -> list[str]:
    return [each["what"] for each in outcome["criteria"] if each["holds"] is False]


def test_a_course_goes_there_and_back_and_is_long_enough() -> None:
    runs = workload(5, seconds=60.0)
    assert all(map(validated, runs))
    for one, following in pairwise(runs):
        assert [robot.goal for robot in one.robots] == [robot.start for robot in following.robots]
    fastest = min(dist(robot.start, robot.goal) / runs[0].control.speed for robot in runs[0].robots)
    assert fastest * len(runs) > 60.0


def test_a_trial_in_which_all_holds() -> None:
    outcome = result(TRIAL, [report(), report(), LAST], samples([9.0] * 10), 0.05)
    assert outcome["passed"]
    assert failures(outcome) == []
    assert json.loads(json.dumps(outcome))["ticks"] == 600


@pytest.mark.parametrize(
    ("reports", "taken", "what"),
    [
        ([report(missed_commands=1), LAST], samples([9.0] * 10), "no command missed"),
        ([report(wall_time=10.6), LAST], samples([9.0] * 10), "real time kept"),
        ([report(collisions=1), LAST], samples([9.0] * 10), "nothing touched"),
        ([report(verdict="deadlock"), LAST], samples([9.0] * 10), "all arrived in every run that ended"),
        (
            [report(), report(reason="world: killed")],
            samples([9.0] * 10),
            "all arrived in every run that ended",
        ),
        ([report(), LAST], samples([9.0] * 10, 0.2), "memory flat in its second half"),
        ([report(), LAST], samples([float(n) for n in range(10)]), "file handles flat"),
    ],
)
def test_a_trial_in_which_something_does_not(reports: list[Any], taken: Samples, what: str) -> None:
    outcome = result(TRIAL, reports, taken, 0.05)
    assert not outcome["passed"]
    assert failures(outcome) == [what]


def test_a_trial_that_is_too_short_does_not_judge_memory() -> None:
    outcome = result(TRIAL, [LAST], samples([9.0] * 3), 0.05)
    assert outcome["passed"]
    assert [each["holds"] for each in outcome["criteria"]][-3:] == [None] * 3
    assert passed([])


@pytest.mark.process
@pytest.mark.alone
@pytest.mark.timeout(60)
def test_a_short_trial() -> None:
    """Judged here is only what a busy machine cannot spoil."""
    call = [sys.executable, "-m", "deploy.cli", "endure", "--minutes", "0.05", "--robots", "3", "--json", "-"]
    done = subprocess.run(call, capture_output=True, text=True, timeout=50, check=False)
    outcome = json.loads(done.stdout)
    assert done.returncode == (0 if outcome["passed"] else 1)
    assert outcome["ended"] == ENOUGH
    assert outcome["ticks"] > 5
    assert outcome["processes"].keys() == {"router", "world", "robot-1", "robot-2", "robot-3", LAUNCHER}
    assert len(outcome["samples"]["world"]["anonymous_mb"]) >= 3
    assert "nothing touched" not in failures(outcome)


def test_a_run_in_one_process_is_no_trial() -> None:
    call = [sys.executable, "-m", "deploy.cli", "endure", "--transport", "local"]
    done = subprocess.run(call, capture_output=True, text=True, timeout=30, check=False)
    assert done.returncode == 2
    assert "'routed', 'mesh'" in done.stderr
