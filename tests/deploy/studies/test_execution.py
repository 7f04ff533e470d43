"""Studies executed: the same rows whatever the jobs, shards and transport, and nothing done twice."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import psutil
import pytest

from deploy.run.options import Transport
from deploy.software import code_digest
from deploy.studies import execution
from deploy.studies.execution import RunLog, RunResult, execute, run_one
from deploy.studies.experiments import tightness
from deploy.studies.study import Build, Shard, Study
from protocol.errors import ProcessError, UsageError
from tests.until import until

COARSE = ("time.step=0.05",)  # fewer ticks


def _study(runs: int = 1) -> Study:
    return tightness(runs).adjusted(COARSE)


def test_a_torn_last_line_is_ignored_and_does_not_spoil_the_next(tmp_path: Path) -> None:
    path = tmp_path / "log"
    log = RunLog(path)
    log.add("a", {"nrl": 1.5})
    log.add("b", {"nrl": 2.5})
    path.write_bytes(path.read_bytes()[:-9])
    log = RunLog(path)
    assert log.known == {"a": {"nrl": 1.5}}
    log.add("c", {"nrl": 3.5})
    assert RunLog(path).known == {"a": {"nrl": 1.5}, "c": {"nrl": 3.5}}
    with pytest.raises(UsageError, match=f"cannot write results to {path}"):
        RunLog(path / "in a file")


def test_shards_share_all_runs_among_them() -> None:
    runs = _study(4).runs("local", "code")
    parts = [Shard(number, 3).part(runs) for number in (1, 2, 3)]
    assert sorted(run.key for part in parts for run in part) == sorted(run.key for run in runs)
    assert Shard.parse("2/3") == Shard(2, 3)
    for wrong in ("0/3", "4/3", "3", "a/b", "1/0"):
        with pytest.raises(UsageError, match="--shard"):
            Shard.parse(wrong)


@pytest.mark.slow
def test_the_logs_of_all_shards_are_the_log_of_the_whole(tmp_path: Path) -> None:
    whole = tmp_path / "whole"
    for number in (1, 2):
        log = RunLog(tmp_path / f"{number}")
        part = execute(_study(), "local", log, jobs=1, shard=Shard(number, 2))
        assert part.complete
        assert 2 <= len(log.known) <= 3
        with whole.open("ab") as file:
            file.write((tmp_path / f"{number}").read_bytes())
    before = whole.read_bytes()
    merged = execute(_study(), "local", RunLog(whole), jobs=1)
    assert (merged.complete, whole.read_bytes()) == (True, before)
    assert merged.rows == execute(_study(), "local", RunLog(None), jobs=2).rows
    assert [row["arrived"] for row in merged.rows] == [1] * 5


def test_other_settings_or_other_code_reuse_nothing() -> None:
    keys = [run.key for run in _study().runs("local", "code")]
    assert not set(keys) & {run.key for run in _study().runs("local", "other code")}
    assert not set(keys) & {run.key for run in tightness(1).runs("local", "code")}
    assert not set(keys) & {run.key for run in _study().runs("routed", "code")}
    assert keys == [run.key for run in _study().runs("local", "code")]


def _lost(*_: object) -> dict[str, object]:
    os._exit(1)


def test_a_worker_that_is_lost_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(execution, "run_one", _lost)
    with pytest.raises(ProcessError, match="to continue"):
        execute(_study(), "local", RunLog(None), jobs=1)


def _signalled(build: Build, seed: int, transport: Transport) -> RunResult:
    os.kill(os.getpid(), signal.SIGINT)
    return run_one(build, seed, transport)


def test_a_worker_leaves_the_signals_of_a_terminal_to_its_parent(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(execution, "run_one", _signalled)
    assert execute(_study(), "local", RunLog(None), jobs=2).complete


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_a_stopped_study_leaves_no_process_and_goes_on(tmp_path: Path, number: signal.Signals) -> None:
    log = tmp_path / "rows.json.runs.jsonl"
    options = ["--runs", "200", "--transport", "local", "--jobs", "2", "--quiet", "--set", *COARSE]
    options += ["--json", str(tmp_path / "rows.json")]
    call = [sys.executable, "-m", "disknav", "study", "tightness", *options]
    process = subprocess.Popen(call, stderr=subprocess.PIPE, text=True, start_new_session=True)
    first = _study().runs("local", code_digest())[0].key
    until(lambda: process.poll() is not None or (log.exists() and first in log.read_text()), 60.0)
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
    assert first in RunLog(log).known
    assert execute(_study(), "local", RunLog(log), jobs=2).complete
