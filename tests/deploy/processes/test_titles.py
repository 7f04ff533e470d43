"""Titles and short names tell the processes of a fleet apart; robots that wait for each other stay on a core
each, and under chrt all processes but the recorder have its priority."""

import os
import subprocess
import sys
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import psutil
import pytest

from deploy.library.load import load
from deploy.processes.spawn import core_of
from deploy.run.options import fresh_run_name
from protocol.scenario.file import write_toml
from tests.until import until

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="elsewhere the system places and orders all")

CHRT = ("chrt", "--rr", "1")


def title(pid: int) -> str:
    """The command line, as `ps -f` shows it."""
    return Path(f"/proc/{pid}/cmdline").read_bytes().rstrip(b"\0").replace(b"\0", b" ").decode()


def children(launcher: int) -> dict[str, tuple[str, set[int]]]:
    """All processes of a fleet that are there now, by title: the short name, as `top`
    shows it, and the policies of the threads."""
    found = {}
    for each in psutil.Process(launcher).children(recursive=True):
        with suppress(psutil.Error, OSError):
            folder = Path(f"/proc/{each.pid}")
            policies = {os.sched_getscheduler(int(task.name)) for task in (folder / "task").iterdir()}
            found[title(each.pid)] = (folder / "comm").read_text().removesuffix("\n"), policies
    return found


def test_robots_are_dealt_out_among_the_cores_there_are(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {5, 2})
    assert [core_of(turn, 5) for turn in range(5)] == [2, 5, 2, 5, 2]


@pytest.mark.process
@pytest.mark.timeout(90)
@pytest.mark.parametrize("chrt", [(), CHRT], ids=["", "chrt"])
def test_a_fleet_is_told_apart_and_has_the_priority_that_it_was_given(
    chrt: tuple[str, ...], tmp_path: Path
) -> None:
    if chrt and subprocess.run([*chrt, "true"], check=False).returncode != 0:
        pytest.skip("no process may have real-time priority here")
    run, pair = fresh_run_name(), load("swap-2", ["control.speed=0.01", "time.limit=60"])
    scenario = replace(pair, robots=(pair.robots[0], replace(pair.robots[1], id=12)))
    (tmp_path / "pair.toml").write_text(write_toml(scenario))
    how = ["run", "pair.toml", "--run", run, "--mode", "realtime", "--quiet", "--record", "run.mcap"]
    names = ["fork server", "router", "recorder", "world", "robot 1", "robot 12"]
    titles = {name: f"disknav {name} (run {run})" for name in names}
    policies = {each: {os.SCHED_RR if chrt else os.SCHED_OTHER} for each in titles.values()}
    policies[titles["recorder"]] = {os.SCHED_OTHER}
    found: dict[str, tuple[str, set[int]]] = {}

    def settled() -> bool:
        found.clear()
        found.update(children(launcher.pid))
        return {each: seen for each, (_, seen) in found.items()} == policies

    with subprocess.Popen([*chrt, sys.executable, "-m", "disknav", *how], cwd=tmp_path) as launcher:
        try:
            until(settled)
        finally:
            launcher.terminate()
    for name in ("robot 1", "robot 12"):
        assert found[titles[name]][0] == f"{name} {run}"[:15]
