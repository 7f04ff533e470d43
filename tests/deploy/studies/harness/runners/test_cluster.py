"""Studies on a Dask cluster of two workers: the rows of one machine, whoever is killed meanwhile."""

from __future__ import annotations

import os
import re
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("distributed")

from distributed import Client, LocalCluster

from deploy.software import scheduler as reached
from deploy.studies.harness.adjusted import adjusted
from deploy.studies.harness.runners import cluster as module
from deploy.studies.harness.runners.cluster import Cluster
from deploy.studies.harness.runners.run_log import RunLog
from deploy.studies.harness.runners.runner import execute
from deploy.studies.harness.study import Study
from deploy.studies.paper.experiments import tightness
from protocol.errors import ProcessError, UsageError
from tests.deploy.telemetry.monitor.watched import until

pytestmark = [pytest.mark.process, pytest.mark.timeout(90)]


def _study(runs: int) -> Study:
    return adjusted(tightness(runs), ("time.step=0.05",))


@pytest.fixture(scope="module")
def scheduler() -> Iterator[str]:
    with LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0", silence_logs=50
    ) as cluster:
        yield cluster.scheduler_address


def _workers(scheduler: str) -> dict[str, int]:
    """Process by address of the worker."""
    with Client(scheduler, set_as_default=False) as client:
        pids: dict[str, int] = client.run(os.getpid)
        return pids


def test_rows_are_those_of_one_machine_though_a_worker_is_killed(scheduler: str, tmp_path: Path) -> None:
    before = until(lambda: found if len(found := _workers(scheduler)) == 2 else None)

    class Killer(RunLog):
        def add(self, key: str, result: dict[str, Any]) -> None:
            if not self.known:  # in the middle: the first batch is done, and the others are not
                os.kill(next(iter(before.values())), signal.SIGKILL)
            super().add(key, result)

    with Killer(tmp_path / "log") as log:
        outcome = execute(_study(4), "local", log, jobs=2, scheduler=scheduler)
    assert outcome.executed == 20
    assert outcome.complete
    assert outcome.rows == execute(_study(4), "local", RunLog(None), jobs=2).rows
    with RunLog(tmp_path / "log") as log:
        again = execute(
            _study(4), "local", log, jobs=2, scheduler="tcp://nobody:1"
        )  # nothing left to ask for
    assert (again.reused, again.executed) == (20, 0)
    assert set(before.values()) - set(until(lambda: _workers(scheduler)).values())


def test_real_processes_on_workers_give_the_same_rows(scheduler: str) -> None:
    routed = execute(_study(1), "routed", RunLog(None), jobs=1, scheduler=scheduler)
    assert routed.executed == 5
    assert routed.rows == execute(_study(1), "local", RunLog(None), jobs=2).rows


def test_what_is_outstanding_is_cancelled(scheduler: str) -> None:
    class Impatient(RunLog):
        def add(self, key: str, result: dict[str, Any]) -> None:
            super().add(key, result)
            raise KeyboardInterrupt

    outcome = execute(_study(40), "local", Impatient(None), jobs=2, scheduler=scheduler)
    assert not outcome.complete
    assert outcome.executed == 1
    with Client(scheduler, set_as_default=False) as client:
        until(lambda: not any(client.processing().values()))


def test_the_scheduler_goes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reached, "_REACHING", 2.0)
    with LocalCluster(
        n_workers=1, threads_per_worker=1, processes=True, dashboard_address=":0", silence_logs=50
    ) as mortal:

        class Killer(RunLog):
            def add(self, key: str, result: dict[str, Any]) -> None:
                super().add(key, result)
                mortal.close()

        with pytest.raises(ProcessError, match=r"is gone.*the same command goes on"):
            execute(_study(8), "local", Killer(None), jobs=1, scheduler=mortal.scheduler_address)


def test_other_code_on_a_worker_is_refused(scheduler: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "code_digest", lambda: "other")
    with pytest.raises(ProcessError, match="another version of disknav"):
        execute(_study(1), "local", RunLog(None), jobs=1, scheduler=scheduler)


def test_nobody_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reached, "_REACHING", 0.3)
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))  # bound, and nobody listens
        address = f"tcp://127.0.0.1:{taken.getsockname()[1]}"
        with pytest.raises(ProcessError, match=f"no Dask scheduler answers at {re.escape(address)}"):
            Cluster(address)
    with pytest.raises(UsageError, match="no address"):
        Cluster("carrier-pigeon://yard")


def test_a_scheduler_without_workers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_GATHERING", 0.2)
    with (
        LocalCluster(n_workers=0, dashboard_address=":0", processes=False, silence_logs=50) as empty,
        pytest.raises(ProcessError, match="has no workers: start some with `dask worker"),
    ):
        Cluster(empty.scheduler_address)


def test_without_the_library(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(UsageError, match=r"distributed.*pip install .*\[cluster\]"):
        Cluster("tcp://127.0.0.1:8786")


def test_a_study_of_speeds_stays_on_one_machine() -> None:
    call = [sys.executable, "-m", "deploy.cli", "study", "scale", "--scheduler", "tcp://127.0.0.1:1"]
    done = subprocess.run(call, capture_output=True, text=True, timeout=30, check=False)
    assert done.returncode == 2
    assert "how fast one machine is" in done.stderr
