"""Studies executed: the same rows whatever the jobs and the transport, and nothing done twice."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import psutil
import pytest

from deploy.studies.harness.adjusted import adjusted
from deploy.studies.harness.runners.run_log import RunLog
from deploy.studies.harness.runners.runner import execute
from deploy.studies.harness.study import Study
from deploy.studies.paper.experiments import tightness
from tests.deploy.telemetry.monitor.watched import until

COARSE = ("time.step=0.05",)  # fewer ticks


def _study(runs: int = 1) -> Study:
    return adjusted(tightness(runs), COARSE)


@pytest.mark.slow
def test_rows_do_not_depend_on_jobs() -> None:
    one = execute(_study(2), "local", RunLog(None), jobs=1)
    two = execute(_study(2), "local", RunLog(None), jobs=2)
    assert one.complete
    assert one.rows == two.rows
    assert [row["arrived"] for row in one.rows] == [2] * 5


@pytest.mark.slow
def test_a_second_call_executes_only_what_is_new(tmp_path: Path) -> None:
    with RunLog(tmp_path / "log") as log:
        execute(_study(1), "local", log, jobs=2)
    with RunLog(tmp_path / "log") as log:
        outcome = execute(_study(2), "local", log, jobs=2)
    assert (outcome.reused, outcome.executed) == (5, 5)
    assert outcome.rows == execute(_study(2), "local", RunLog(None), jobs=2).rows


def test_other_settings_or_other_code_reuse_nothing() -> None:
    keys = [run.key for run in _study().runs("local", "code")]
    assert not set(keys) & {run.key for run in _study().runs("local", "other code")}
    assert not set(keys) & {run.key for run in tightness(1).runs("local", "code")}
    assert not set(keys) & {run.key for run in _study().runs("routed", "code")}
    assert keys == [run.key for run in _study().runs("local", "code")]


@pytest.mark.alone  # it has to be stopped before it is done
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
@pytest.mark.long(12)
def test_a_study_that_was_stopped_leaves_nobody_and_goes_on(tmp_path: Path, number: signal.Signals) -> None:
    log = tmp_path / "rows.json.runs.jsonl"
    command = "from deploy.commands.study import study; import typer; typer.run(study)"
    options = f"tightness --runs 16 --transport local --jobs 2 --quiet --set {COARSE[0]} --json".split()
    call = [sys.executable, "-c", command, *options, str(tmp_path / "rows.json")]
    process = subprocess.Popen(call, stderr=subprocess.PIPE, text=True, start_new_session=True)
    until(lambda: process.poll() is not None or (log.exists() and log.read_text().count("\n") >= 2))
    workers = psutil.Process(process.pid).children(recursive=True)
    assert len(workers) >= 2
    if number == signal.SIGINT:
        os.killpg(process.pid, number)  # as a terminal does: to the workers, too
    else:
        process.kill()
    _, said = process.communicate(timeout=30.0)
    assert process.returncode == (130 if number == signal.SIGINT else -number)
    assert "Traceback" not in said
    until(lambda: not any(each.is_running() and each.status() != "zombie" for each in workers))
    with RunLog(log) as kept:
        outcome = execute(_study(16), "local", kept, jobs=2)
    assert outcome.reused >= 2
    assert outcome.reused + outcome.executed == 80
    assert outcome.complete


@pytest.mark.process
def test_real_processes_give_the_same_rows_and_go_from_run_to_run() -> None:
    """35 runs on the processes of two fleets: the smoke of figure 4."""
    routed = execute(_study(7), "routed", RunLog(None), jobs=2)
    assert routed.executed == 35
    assert [row["arrived"] for row in routed.rows] == [7] * 5
    assert routed.rows == execute(_study(7), "local", RunLog(None), jobs=2).rows
