"""Router, world and robots started one by one: in any order, and the world's status tells the verdict."""

import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from deploy.output import EXIT_FAULT, EXIT_OTHERWISE
from tests.deploy.processes.ports import free_ports
from tests.system.orders.test_orders import reachable
from tests.until import until

pytestmark = [pytest.mark.process, pytest.mark.timeout(110)]

ROBOTS = ("1", "2", "3")  # of figure-2


class ByHand:
    """Processes of one run, each started by a command of its own."""

    def __init__(self) -> None:
        (port,) = free_ports(1)
        self.endpoint = f"tcp/127.0.0.1:{port}"
        self.processes: list[subprocess.Popen[str]] = []

    def start(self, *command: str, run: str = "hand", wait: float = 60.0) -> subprocess.Popen[str]:
        connection = (
            ["--listen", self.endpoint]
            if command[0] == "router"
            else ["--router", self.endpoint, "--run", run, "--wait", str(wait)]
        )
        call = [sys.executable, "-m", "disknav", "node", *command, *connection]
        process = subprocess.Popen(call, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.processes.append(process)
        return process


@contextmanager
def by_hand() -> Iterator[ByHand]:
    it = ByHand()
    try:
        yield it
    finally:
        for process in it.processes:
            process.kill()
            process.communicate()


def said(process: subprocess.Popen[str]) -> tuple[int, dict[str, Any]]:
    out, error = process.communicate(timeout=90.0)
    assert out, error
    return process.returncode, json.loads(out)


def test_robots_first_router_last(tmp_path: Path) -> None:
    alive = [tmp_path / robot for robot in ROBOTS]
    with by_hand() as it:
        logs = ["--log", str(tmp_path / "logs")]
        robots = [it.start("robot", r, "--alive", str(f), *logs) for r, f in zip(ROBOTS, alive, strict=True)]
        world = it.start("world", "figure-2", "--set", "time.limit=0.5", *logs)
        it.start("router", *logs)
        found, report = said(world)
        assert (found, report["verdict"]) == (EXIT_OTHERWISE, "timeout")
        assert [robot.wait(30.0) for robot in robots] == [0, 0, 0]
    assert all(file.exists() for file in alive)
    said_by = {path.stem: path.read_text() for path in (tmp_path / "logs").iterdir()}
    assert said_by.keys() == {"router", "world", *(f"robot-{robot}" for robot in ROBOTS)}
    assert "the run is over: timeout" in said_by["robot-1"]
    assert "ends: timeout" in said_by["world"]
    assert it.endpoint in said_by["router"]


def test_no_process_waits_for_longer_than_asked() -> None:
    with by_hand() as nowhere, by_hand() as it:
        lost = nowhere.start("robot", "1", wait=1.0)
        it.start("router")
        until(lambda: reachable(it.endpoint), 60.0)
        alone = it.start("robot", "1", wait=2.0)
        empty = it.start("world", "figure-2", run="empty", wait=1.0)
        assert [each.wait(60.0) for each in (lost, alone)] == [EXIT_FAULT] * 2
        assert "no world answers" in alone.stderr.read()
        found, report = said(empty)
        assert (found, report["verdict"]) == (EXIT_FAULT, "aborted")
