"""Robots that wait for each other stay on a core each; under chrt all but the recorder have its priority."""

import os
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import psutil
import pytest

from deploy.processes.spawn import core_of
from tests.until import until

linux = pytest.mark.skipif(sys.platform != "linux", reason="elsewhere the system places and orders all")


@linux
def test_robots_are_dealt_out_among_the_cores_there_are(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {5, 2})
    assert [core_of(turn, 5) for turn in range(5)] == [2, 5, 2, 5, 2]


def policies(pid: int) -> set[int]:
    return {os.sched_getscheduler(int(task.name)) for task in Path(f"/proc/{pid}/task").iterdir()}


@linux
@pytest.mark.process
@pytest.mark.timeout(60)
@pytest.mark.skipif(
    subprocess.run(["chrt", "--rr", "1", "true"], check=False).returncode != 0,
    reason="no process may have real-time priority here",
)
def test_a_fleet_under_chrt_has_real_time_priority_but_for_its_recorder(tmp_path: Path) -> None:
    how = ["--mode", "realtime", "--set", "control.speed=0.01", "--set", "time.limit=40", "--quiet"]
    call = ["chrt", "--rr", "1", sys.executable, "-m", "disknav", "run", "swap-2", *how]
    with subprocess.Popen([*call, "--record", str(tmp_path / "run.mcap")]) as launcher:
        try:
            until(lambda: len(found := children(launcher.pid)) >= 5 and SCHED_OTHER in found.values(), 40.0)
            found = children(launcher.pid)
        finally:
            launcher.terminate()
    ordinary = {name for name, these in found.items() if these == SCHED_OTHER}
    assert all("recorder" in name for name in ordinary)
    names = {"router", "world", "robot 1", "robot 2"}
    assert {name for name in names if any(f" {name} " in each for each in found.keys() - ordinary)} == names


SCHED_OTHER = {os.SCHED_OTHER}


def children(launcher: int) -> dict[str, set[int]]:
    """Policies of all processes of a fleet that are there now, by title."""
    found = {}
    for each in psutil.Process(launcher).children(recursive=True):
        with suppress(psutil.Error, OSError):
            found[" ".join(each.cmdline())] = policies(each.pid)
    return found
