"""Titles tell processes apart: in a fleet, alone, after a restart; `pgrep` finds the one that is meant."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import psutil
import pytest

from deploy.library.load import load
from deploy.processes.spawn import Spawner
from deploy.processes.supervisor import Supervisor
from deploy.run.fleet import Fleet
from deploy.run.options import RunOptions, fresh_run_name
from protocol.messages import Clock
from tests.deploy.processes.children import row, wait
from tests.deploy.processes.ports import free_ports

pytestmark = [
    pytest.mark.process,
    pytest.mark.timeout(90),
    pytest.mark.skipif(sys.platform != "linux", reason="reads /proc"),
]

DISKNAV = [sys.executable, "-m", "disknav"]
PATIENCE = 30.0  # s


def title(pid: int) -> str:
    """The command line, as `ps -f` shows it."""
    return Path(f"/proc/{pid}/cmdline").read_bytes().rstrip(b"\0").replace(b"\0", b" ").decode()


def short(pid: int) -> str:
    """The short name, as `top` shows it."""
    return Path(f"/proc/{pid}/comm").read_text().removesuffix("\n")


def found(pattern: str) -> list[int]:
    """The processes that `pgrep -f` finds."""
    done = subprocess.run(["pgrep", "-f", pattern], capture_output=True, text=True, check=False)
    return [int(pid) for pid in done.stdout.split()]


def await_title(process: subprocess.Popen[Any], expected: str) -> None:
    deadline = time.monotonic() + PATIENCE
    while title(process.pid) != expected:
        assert process.poll() is None, f"{expected} ended by itself"
        assert time.monotonic() < deadline, title(process.pid)
        time.sleep(0.02)


def test_a_fleet_is_told_apart_and_the_one_that_is_meant_is_killed(tmp_path: Path) -> None:
    run = fresh_run_name()
    scenario = load("swap-12", ["control.speed=0.01", "time.limit=60"])
    seen: dict[str, int] = {}
    titles: set[str] = set()

    def look(clock: Clock) -> None:
        if clock.tick < 2 or seen:
            return
        seen.update(fleet.pids())
        assert {name: title(pid) for name, pid in seen.items()} == {
            name: f"disknav {name.replace('-', ' ')} (run {run})" for name in seen
        }
        assert short(seen["robot-1"]) == f"robot 1 {run}"[:15]
        assert short(seen["robot-12"]) == f"robot 12 {run}"[:15]
        server = psutil.Process(seen["world"]).parent()
        assert server is not None
        titles.update(title(each.pid) for each in [server, *server.children(recursive=True)])
        hit = found(rf"disknav robot 1 \(run {run}\)")
        assert hit == [seen["robot-1"]]
        os.kill(hit[0], signal.SIGKILL)

    options = RunOptions(mode="realtime", run=run)
    with Fleet(scenario, options, watch=look, record=tmp_path / "run.mcap") as fleet:
        fleet.execute(enough=lambda: bool(seen) and "robot-1" not in fleet.pids())
        ends = {each["name"]: each["exit_code"] for each in fleet.processes()}
    assert ends.pop("recorder") is None, "it waits for the result"
    assert ends == {name: -signal.SIGKILL if name == "robot-1" else 0 for name in ends}
    names = ["fork server", "router", "recorder", "world", *(f"robot {n}" for n in scenario.ids)]
    assert titles == {f"disknav {name} (run {run})" for name in names}


def test_titles_are_whole_and_the_same_after_a_restart() -> None:
    """Forks write where their parent's title stood, whether theirs is longer or shorter."""
    run, long = "r" * 300, "router-" + "h" * 200
    with Supervisor(Spawner(("tests.deploy.processes.children",), run)) as supervisor:
        supervisor.start([row(name, wait, reports=True) for name in (long, "robot-3", "world")])
        for name in (long, "robot-3", "world"):
            supervisor.report(name, PATIENCE)
        before = supervisor.pids()
        supervisor.restart("robot-3")
        supervisor.report("robot-3", PATIENCE)
        after = supervisor.pids()
        assert before["robot-3"] != after["robot-3"]
        server = psutil.Process(after["world"]).ppid()
        assert {title(pid) for pid in after.values()} == {
            f"disknav router {'h' * 200} (run {run})",
            f"disknav robot 3 (run {run})",
            f"disknav world (run {run})",
        }
        assert title(server) == f"disknav fork server (run {run})"


@pytest.mark.campaign
def test_processes_that_are_started_alone() -> None:
    """In an environment that leaves little room for titles."""
    run, endpoint = fresh_run_name(), f"tcp/127.0.0.1:{free_ports(1)[0]}"
    attached = ["--run", run, "--router", endpoint]
    commands = {
        "disknav router": ["node", "router", "--listen", endpoint],
        f"disknav world (run {run})": ["node", "world", "figure-2", *attached],
        f"disknav robot 1 (run {run})": ["node", "robot", "1", *attached],
        f"disknav monitor (run {run})": ["monitor", run, *attached[2:]],
    }
    with ExitStack() as stack:
        for expected, command in commands.items():
            process = subprocess.Popen(
                [*DISKNAV, *command],
                stdout=subprocess.DEVNULL,
                env={"PYTHONPATH": os.pathsep.join(sys.path)},
            )
            stack.callback(process.wait)
            stack.callback(process.kill)
            await_title(process, expected)
