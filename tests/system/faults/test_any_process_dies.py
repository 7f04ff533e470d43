"""kill -9 of world, router and robots, on real processes: the run goes on, and nothing touches."""

import json
import random
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

import msgspec
import pytest

from deploy.library.load import load
from deploy.processes import table
from deploy.processes.hosts.table import parse_hosts
from deploy.processes.supervisor import Supervisor
from deploy.run.fleet import Fleet
from deploy.run.operator import operating
from deploy.run.options import RunOptions, Transport, fresh_run_name
from deploy.telemetry.recording.reader import read
from deploy.telemetry.recording.replay import recomputed
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from protocol.errors import RecordingError
from protocol.keys import world_key
from protocol.messages import Clock
from protocol.operations import Steer
from protocol.scenario.model import Scenario
from tests.deploy.processes.ports import free_ports
from tests.until import until

pytestmark = [pytest.mark.process, pytest.mark.timeout(150)]

QUICK, PAIR = load("swap-6"), load("swap-2")


class Killer:
    def __init__(self, deaths: Sequence[tuple[int, str]]) -> None:
        self.due = sorted(deaths)
        self._killed: set[int] = set()

    def __call__(self, fleet: Fleet, clock: Clock) -> None:
        while self.due and clock.tick >= self.due[0][0]:
            (row,) = (each for each in fleet.supervisor.usage() if each.name == self.due[0][1])
            pid = row.pid if row.exit_code is None else 0
            if not pid or pid in self._killed:
                return  # its next life has not begun
            self._killed.add(pid)
            fleet.supervisor.signal(self.due.pop(0)[1], signal.SIGKILL)


def run(
    scenario: Scenario, options: RunOptions, kill: Callable[[Fleet, Clock], None], record: Path | None = None
) -> tuple[dict[str, Any], dict[str, int]]:
    """The report, and how often processes were started again, by name, of those that were."""
    with Fleet(scenario, options, watch=lambda clock: kill(fleet, clock), record=record) as fleet:
        report = fleet.execute()
        rows = fleet.processes()
    return report, {row["name"]: row["restarts"] for row in rows if row.get("restarts")}


def unhurt(report: dict[str, Any]) -> bool:
    return report["verdict"] == "arrived" and report["collisions"] == 0


def test_real_time_goes_on_too() -> None:
    deaths = [(8, "robot-2"), (14, table.WORLD), (22, table.ROUTER), (30, "robot-1")]
    options = RunOptions(mode="realtime", restarts=3)
    report, restarts = run(load("figure-3b", ["control.speed=0.3"], 2), options, Killer(deaths))
    assert unhurt(report)
    assert all(restarts[name] == 1 for _, name in deaths)


def test_on_two_hosts() -> None:
    left, right = free_ports(2)
    hosts = [
        {"name": "left", "address": "127.0.0.1", "port": left, "robots": [1, 2, 3]},
        {"name": "right", "address": "127.0.0.1", "port": right, "robots": [4, 5, 6]},
    ]
    options = RunOptions(hosts=parse_hosts({"hosts": hosts}, QUICK.ids), restarts=3, speed=10.0)
    killer = Killer([(40, "router-right"), (80, table.WORLD)])
    report, restarts = run(QUICK, options, killer)
    assert killer.due == []
    assert unhurt(report)
    assert len(report["worlds"]) == 1
    assert restarts == {"router-right": 1, "world": 1}


@pytest.mark.parametrize("transport", ["routed", "mesh"])
def test_a_run_and_its_recording_go_on(transport: Transport, tmp_path: Path) -> None:
    path, tick = tmp_path / "run.mcap", random.randrange(1, 100)
    deaths = [(tick, "robot-2"), (tick, table.WORLD), (tick + 30, "robot-5"), (tick + 60, table.WORLD)]
    if transport == "routed":
        deaths.append((tick + 31, table.ROUTER))
    report, restarts = run(
        QUICK, RunOptions(transport, restarts=3, speed=10.0), killer := Killer(deaths), path
    )
    assert killer.due == []
    assert unhurt(report), (tick, report)
    assert 1 <= len(report["worlds"]) <= 2  # one that dies before it has read the checkpoint does not
    assert restarts == Counter(name for _, name in deaths)
    recording = read(path)
    assert recording.result is not None
    try:
        assert recomputed(recording).sha256 == report["trajectory_sha256"]
    except RecordingError as error:  # no router holds a tick back until the recorder has found the new world
        assert transport == "mesh"
        assert f"tick {report['worlds'][-1]}, the first of" in str(error)


@pytest.mark.parametrize("name", [table.WORLD, table.ROUTER])
def test_more_deaths_than_the_policy_allows_end_the_run(name: str) -> None:
    killer = Killer([(10, name), (20, name)])
    report, restarts = run(QUICK, RunOptions(restarts=1, speed=1.0), killer)
    assert report["verdict"] == "aborted"
    assert name in report["reason"]
    assert restarts[name] == 1


def test_a_robot_that_dies_more_often_stays_down_and_is_flowed_around() -> None:
    killer = Killer([(10, "robot-2"), (20, "robot-2")])
    options = RunOptions(restarts=1, speed=1.0)  # slow enough to be watched on a busy machine
    report, restarts = run(load("random-4", ["time.fence=0.3"], 3), options, killer)
    assert killer.due == []
    assert report["verdict"] == "aborted"
    assert "robot 2" in report["reason"]
    assert (report["collisions"], report["down"], report["arrived"]) == (0, [2], [1, 3, 4])
    assert restarts == {"robot-2": 1}


def test_no_world_begins_without_its_checkpoint(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    checkpoints: list[Path] = []
    row = table.world
    monkeypatch.setattr(table, "world", lambda *a, **k: checkpoints.append(k["checkpoint"]) or row(*a, **k))

    def act(fleet: Fleet, clock: Clock) -> None:
        if clock.tick >= 10 and checkpoints[0].exists():
            checkpoints[0].unlink()
            fleet.supervisor.signal(table.WORLD, signal.SIGKILL)

    report, _ = run(QUICK, RunOptions(restarts=1000, speed=1.0), act)
    assert report["verdict"] == "aborted"
    assert f"the checkpoint {checkpoints[0]} does not exist" in capfd.readouterr().err


def test_a_world_under_another_launcher(tmp_path: Path) -> None:
    """Its clock is held from the beginning, so that it dies in the middle of the run on any machine."""
    checkpoint, name = tmp_path / "yard.checkpoint", fresh_run_name()
    with Supervisor() as supervisor:
        supervisor.start([table.router(Connection("router"))])
        connection = Connection(connect=(supervisor.report(table.ROUTER, 20.0),))
        command = [sys.executable, "-m", "disknav", "node", "world", PAIR.name, "--run", name]
        command += ["--router", connection.connect[0], "--checkpoint", str(checkpoint)]
        with subprocess.Popen(command) as first, operating(name, connection.connect[0]) as operator:
            with closing(ZenohBus(connection)) as bus:
                bus.ask(world_key(name, "steering"), msgspec.msgpack.encode(Steer(step=60)), 60.0)
            supervisor.start([table.robot(connection, name, robot) for robot in PAIR.ids])
            until(lambda: operator.operate().tick >= 60, 60.0)
            first.kill()
        again = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    assert "world: goes on at tick 60" in again.stderr
    assert unhurt(json.loads(again.stdout))
    assert not checkpoint.exists()
