"""Real processes on real zenoh: the trajectory of a run in one process, and what is refused."""

from dataclasses import replace
from pathlib import Path

import pytest

from agents.process import REFUSED
from deploy.library.load import load
from deploy.output import EXIT_INVALID
from deploy.processes import table
from deploy.processes.supervisor import Supervisor
from deploy.run.fleet import Fleet
from deploy.run.local import LocalFleet
from deploy.run.options import RunOptions, fresh_run_name
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from protocol.errors import ProcessError
from protocol.scenario.model import ProcessFault
from protocol.scenario.network import Network
from tests.forks import Forks
from tests.until import until

pytestmark = [pytest.mark.process, pytest.mark.timeout(150)]


def test_faults_among_robots_that_hear_those_near_them_are_the_same_on_real_processes() -> None:
    scenario = load("figure-3b", ["link.delay=[0.0, 0.2]", "link.loss=0.3", "sensing.noise=0.001"], 5)
    events = ((2, 0.5, "pause"), (2, 2.5, "resume"), (4, 0.7, "restart"), (5, 0.4, "pause"))
    events += ((5, 0.6, "resume"),)
    faults = tuple(ProcessFault(*event) for event in events)  # type: ignore[arg-type]
    scenario = replace(scenario, process=faults, network=Network("near", 0.1))
    local = LocalFleet(scenario).execute()
    with Fleet(scenario, RunOptions("routed")) as fleet:
        routed = fleet.execute()
        rows = {row["name"]: row for row in fleet.processes()}
    assert local["verdict"] == routed["verdict"] == "arrived"
    assert local["trajectory_sha256"] == routed["trajectory_sha256"]
    assert {name: row["restarts"] for name, row in rows.items() if row["restarts"]} == {"robot-4": 1}
    assert {row["exit_code"] for row in rows.values()} == {0}


def test_a_second_robot_with_the_same_id_is_refused(endpoint: str) -> None:
    scenario, run, connection = load("figure-2"), fresh_run_name(), Connection(connect=(endpoint,))
    with Supervisor() as supervisor:
        supervisor.start([table.world(connection, run, scenario, True), table.robot(connection, run, 1)])
        bus = ZenohBus(connection)
        bus.watch(f"disknav/{run}/robot/1/alive/*")
        until(lambda: supervisor.poll() or bus.receive(0.05))
        bus.close()
        supervisor.start([table.Process("twin", "agents.process:main", (connection, run, 1))])
        exits = until(lambda: supervisor.poll(0.1))
    assert [(exit_.process.name, exit_.code) for exit_ in exits] == [("twin", REFUSED)]


def test_a_fleet_that_may_not_open_its_files_is_not_started(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("deploy.run.fleet.getrlimit", lambda _: (15, 15))
    with pytest.raises(ProcessError, match="ulimit -n 38"), Fleet(load("swap-6"), RunOptions()):
        pytest.fail("it has started")


def test_a_malformed_scenario_starts_nothing(disknav: Forks, tmp_path: Path) -> None:
    path = tmp_path / "bad.toml"
    path.write_text(
        "[[robots]]\nid = 1\nradius = 0.04\nstart = [0, 0]\ngoal = [9, 0]\n[wrkspace]\nradius = 1\n"
    )
    done = disknav("run", path)
    assert done.returncode == EXIT_INVALID
    assert "robots[0].goal" in done.stderr
    assert "workspace" in done.stderr
