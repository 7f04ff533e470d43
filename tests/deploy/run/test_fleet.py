"""Real processes on real zenoh: arrival, determinism across transports, and everything that can go wrong."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import psutil
import pytest

from agents.process import REFUSED
from deploy.library.load import load
from deploy.output.exit_status import EXIT_INTERRUPTED, EXIT_INVALID
from deploy.processes import table
from deploy.processes.supervisor import Supervisor
from deploy.run.fleet import Fleet
from deploy.run.local import LocalFleet
from deploy.run.options import Mode, RunOptions, Transport, fresh_run_name, restarts
from protocol.bus.connection import Connection
from protocol.bus.events import Sample
from protocol.bus.zenoh import ZenohBus
from protocol.errors import UsageError
from protocol.keys import world_key
from protocol.messages import Clock, Result
from protocol.scenario.model import ProcessFault, Scenario
from protocol.wire.codec import decode
from tests.deploy.processes.test_spawn import gone
from tests.deploy.telemetry.monitor.watched import until

pytestmark = [pytest.mark.process, pytest.mark.timeout(150)]

DISKNAV = [sys.executable, "-m", "deploy.cli"]


def run_fleet(
    scenario: Scenario, options: RunOptions, act: Callable[..., None] | None = None
) -> dict[str, Any]:
    """The report of one run; `act(fleet, message)` may interfere."""
    fleet: Fleet

    def watch(message: Clock) -> None:
        if act is not None:
            act(fleet, message)

    with Fleet([scenario], options, watch=watch) as fleet:
        report = fleet.execute()[0]
        report["processes"] = fleet.processes()
    return report


@contextmanager
def router(supervisor: Supervisor) -> Iterator[Connection]:
    supervisor.start([table.router(Connection("router"))])
    yield Connection(connect=(supervisor.report("router", 20.0),))


def result_of(
    connection: Connection, run: str, supervisor: Supervisor, rows: list[table.Process]
) -> dict[str, Any]:
    """Start `rows`, a world among them, and wait for its result."""
    seconds = 40.0
    bus = ZenohBus(connection)
    try:
        bus.subscribe(world_key(run, "result"))
        supervisor.start(rows)
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            supervisor.poll()
            event = bus.receive(0.05)
            if isinstance(event, Sample):
                message = decode(event.key, event.payload)
                assert isinstance(message, Result)
                return json.loads(message.report)
    finally:
        bus.close()
    raise AssertionError(f"no result within {seconds} s")


def test_the_same_run_on_every_transport_and_again() -> None:
    scenario = load("figure-3c", [], 11)
    local = LocalFleet([scenario]).execute()[0]
    routed = run_fleet(scenario, RunOptions("routed"))
    mesh = run_fleet(scenario, RunOptions("mesh"))
    again = run_fleet(scenario, RunOptions("routed"))
    assert {r["verdict"] for r in (local, routed, mesh, again)} == {"arrived"}
    assert len({r["trajectory_sha256"] for r in (local, routed, mesh, again)}) == 1
    assert all(process["exit_code"] == 0 for process in routed["processes"])


def test_scheduled_faults_are_the_same_on_real_processes() -> None:
    scenario = load("figure-3b", ["link.delay=[0.0, 0.2]", "link.loss=0.3", "sensing.noise=0.001"], 5)
    events = (
        (2, 0.5, "pause"),
        (2, 2.5, "resume"),
        (4, 0.7, "restart"),
        (5, 0.4, "pause"),
        (5, 0.6, "resume"),
    )
    scenario = replace(scenario, process=tuple(ProcessFault(*event) for event in events))  # type: ignore[arg-type]
    local = LocalFleet([scenario]).execute()[0]
    routed = run_fleet(scenario, RunOptions("routed"))
    assert local["verdict"] == routed["verdict"] == "arrived"
    assert local["trajectory_sha256"] == routed["trajectory_sha256"]
    assert [p["restarts"] for p in routed["processes"] if p["name"] == "robot-4"] == [1]


def test_one_fleet_runs_many_scenarios_on_the_same_processes() -> None:
    scenarios = [load("figure-3a", [], seed) for seed in range(4)]
    with Fleet(scenarios, RunOptions()) as fleet:
        reports = fleet.execute()
        processes = fleet.processes()
    alone = [LocalFleet([scenario]).execute()[0] for scenario in scenarios]
    assert [r["trajectory_sha256"] for r in reports] == [r["trajectory_sha256"] for r in alone]
    assert all(process["restarts"] == 0 for process in processes)


def test_whoever_a_run_leaves_dead_or_frozen_is_back_for_the_next() -> None:
    faults = (ProcessFault(2, 0.3, "kill"), ProcessFault(3, 0.3, "pause"))
    quick = ["time.fence=0.2", "time.limit=2.0"]
    scenarios = [replace(load("figure-3a", quick, 1), process=faults), load("figure-3a", [], 2)]
    with Fleet(scenarios, RunOptions()) as fleet:
        reports = fleet.execute()
    local = LocalFleet(scenarios).execute()
    assert reports[1]["verdict"] == "arrived"
    assert [r["trajectory_sha256"] for r in reports] == [r["trajectory_sha256"] for r in local]


def test_a_killed_robot_is_flowed_around_and_the_run_ends() -> None:
    killed = []

    def act(fleet: Fleet, message: Clock) -> None:
        if message.tick >= 10 and not killed:
            killed.append(message.tick)
            fleet.signal("robot-2", signal.SIGKILL)

    slowly = RunOptions(speed=1.0)  # enough to be watched on a busy machine
    report = run_fleet(load("random-4", ["time.fence=0.3"], 3), slowly, act)
    assert killed
    assert report["verdict"] == "aborted"
    assert "robot 2" in report["reason"]
    assert report["collisions"] == 0
    assert report["arrived"] == [1, 3, 4]


@pytest.mark.parametrize("mode", ["lockstep", "realtime"])
def test_by_policy_a_killed_robot_comes_back_and_the_run_succeeds(mode: Mode) -> None:
    killed: list[int] = []

    def act(fleet: Fleet, message: Clock) -> None:
        life = fleet.pids().get("robot-2")  # both kills must not meet the same one
        if message.tick >= 10 * (len(killed) + 1) and len(killed) < 2 and life and life not in killed:
            killed.append(life)
            fleet.signal("robot-2", signal.SIGKILL)

    options = RunOptions(mode=mode, restarts=2, speed=1.0)  # slow enough to be watched on a busy machine
    report = run_fleet(load("figure-3b", ["control.speed=0.3"], 2), options, act)
    assert len(killed) == 2
    assert (report["verdict"], report["collisions"]) == ("arrived", 0)
    restarts = {process["name"]: process["restarts"] for process in report["processes"]}
    assert restarts.pop("robot-2") == 2
    assert set(restarts.values()) == {0}


def test_a_robot_that_fails_more_often_than_the_policy_allows_stays_down() -> None:
    killed: list[int] = []

    def act(fleet: Fleet, message: Clock) -> None:
        life = fleet.pids().get("robot-2")  # both kills must not meet the same one
        if message.tick >= 10 * (len(killed) + 1) and len(killed) < 2 and life and life not in killed:
            killed.append(life)
            fleet.signal("robot-2", signal.SIGKILL)

    report = run_fleet(load("random-4", ["time.fence=0.3"], 3), RunOptions(restarts=1, speed=2.0), act)
    assert report["verdict"] == "aborted"
    assert report["down"] == [2]


def test_policies() -> None:
    assert [restarts(policy) for policy in ("never", "on-failure", "on-failure:7")] == [0, 3, 7]
    for policy in ("always", "on-failure:", "on-failure:0", "on-failure:-1", "on-failure:x"):
        with pytest.raises(UsageError, match="on-failure:N"):
            restarts(policy)
    with pytest.raises(UsageError, match="--transport local"):
        RunOptions("local", restarts=1)


def test_a_world_that_dies_leaves_a_readable_result() -> None:
    def act(fleet: Fleet, message: Clock) -> None:
        if message.tick >= 5:
            fleet.signal("world", signal.SIGKILL)

    report = run_fleet(load("figure-3a", [], 0), RunOptions(speed=1.0), act)
    assert report["verdict"] == "aborted"
    assert "world" in report["reason"]
    assert report["ticks"] >= 5
    robots = [process for process in report["processes"] if process["name"].startswith("robot")]
    assert all(process["exit_code"] is not None for process in robots)


def test_a_robot_that_never_starts_is_named() -> None:
    scenario, run = load("figure-2"), fresh_run_name()
    with Supervisor() as supervisor, router(supervisor) as connection:
        rows = [table.world(connection, run, [scenario], True, 5.0)]
        rows += [table.robot(connection, run, robot) for robot in (1, 3)]
        report = result_of(connection, run, supervisor, rows)
    assert report["verdict"] == "aborted"
    assert "robot 2 " in report["reason"]


def test_a_second_robot_with_the_same_id_is_refused() -> None:
    scenario, run = load("figure-2"), fresh_run_name()
    with Supervisor() as supervisor, router(supervisor) as connection:
        supervisor.start([table.world(connection, run, [scenario], True), table.robot(connection, run, 1)])
        twin = table.Process("twin", "agents.process:main", (connection, run, 1))
        deadline = time.monotonic() + 30.0
        bus = ZenohBus(connection)
        bus.watch(f"disknav/{run}/robot/1/alive")
        while bus.receive(0.05) is None and time.monotonic() < deadline:
            supervisor.poll()
        bus.close()
        supervisor.start([twin])
        exits: list[Any] = []
        while not exits and time.monotonic() < deadline:
            exits = supervisor.poll(0.1)
    assert [(exit_.process.name, exit_.code) for exit_ in exits] == [("twin", REFUSED)]


def test_two_fleets_share_a_router() -> None:
    scenarios = [load("figure-3a", [], seed) for seed in (1, 2)]
    with Supervisor() as supervisor, router(supervisor) as connection:
        options = [RunOptions(router=connection.connect[0]) for _ in scenarios]
        with Fleet([scenarios[0]], options[0]) as one, Fleet([scenarios[1]], options[1]) as two:
            reports = [one.execute()[0], two.execute()[0]]
    alone = [LocalFleet([scenario]).execute()[0] for scenario in scenarios]
    assert [r["trajectory_sha256"] for r in reports] == [r["trajectory_sha256"] for r in alone]


@pytest.mark.parametrize(
    ("number", "times", "starting"),
    [
        (signal.SIGINT, 1, False),
        (signal.SIGTERM, 1, False),
        (signal.SIGINT, 4, False),
        (signal.SIGINT, 2, True),
    ],
)
def test_a_signal_stops_everything_and_leaves_a_result(
    number: int, times: int, starting: bool, tmp_path: Path
) -> None:
    target, recording = tmp_path / "result.json", tmp_path / "run.mcap"
    command = [*DISKNAV, "run", "swap-6", "--mode", "realtime", "--quiet", "--json", str(target)]
    command += ["--record", str(recording), "--set", "control.speed=0.01"]
    process = subprocess.Popen(command, start_new_session=True)
    if starting:
        until(lambda: psutil.Process(process.pid).children(recursive=True))  # the fork server, to begin with
        family = psutil.Process(process.pid).children(recursive=True)
    else:
        family = _wait_for_family(process, recording)
    for _ in range(times):
        process.send_signal(number)
        with suppress(subprocess.TimeoutExpired):
            process.wait(0.1)
    assert process.wait(20.0) == EXIT_INTERRUPTED
    assert json.loads(target.read_text())["verdict"] == "interrupted"
    assert all(gone(each.pid) for each in family)


def interrupt() -> None:
    """As a callback may, rather than the terminal."""
    raise KeyboardInterrupt


@pytest.mark.parametrize("tick", [0, 3])
@pytest.mark.parametrize("transport", ["routed", "mesh"])
def test_ctrl_c_in_the_second_run_leaves_the_report_of_the_first(transport: Transport, tick: int) -> None:
    scenario = load("swap-2")
    first = replace(scenario, time=replace(scenario.time, limit=5 * scenario.time.step))

    interruptions = iter([interrupt if tick else lambda: signal.raise_signal(signal.SIGINT)])

    def watch(clock: Clock) -> None:
        if clock.run_number == 1 and clock.tick >= tick:
            for interruption in interruptions:
                interruption()

    options = RunOptions(transport, speed=1.0)
    with Fleet([first, replace(scenario, name="second")], options, watch=watch) as fleet:
        reports = fleet.execute()
    told = [(report["scenario"], report["run_number"], report["verdict"]) for report in reports]
    assert told == [("swap-2", 0, "timeout"), ("second", 1, "interrupted")]


def test_ctrl_c_while_a_report_is_taken_changes_nothing_about_it() -> None:
    def digest(report: dict[str, Any]) -> dict[str, Any]:
        signal.raise_signal(signal.SIGINT)
        return report

    with Fleet([load("swap-2")], RunOptions("mesh"), digest=digest) as fleet:
        (report,) = fleet.execute()
    assert report["verdict"] == "arrived"


def test_a_malformed_scenario_starts_nothing(tmp_path: Any) -> None:
    path = tmp_path / "bad.toml"
    path.write_text(
        "[[robots]]\nid = 1\nradius = 0.04\nstart = [0, 0]\ngoal = [9, 0]\n[wrkspace]\nradius = 1\n"
    )
    done = subprocess.run(
        [*DISKNAV, "run", str(path)], capture_output=True, text=True, timeout=30, check=False
    )
    assert done.returncode == EXIT_INVALID
    assert "robots[0].goal" in done.stderr
    assert "workspace" in done.stderr


def _wait_for_family(process: subprocess.Popen[bytes], recording: Path) -> list[psutil.Process]:
    """The processes that a command has started, once they make ticks."""
    deadline = time.monotonic() + 60.0
    while time.monotonic() < deadline:
        if recording.exists() and recording.stat().st_size > 20_000:  # much more than the scenario
            return psutil.Process(process.pid).children(recursive=True)
        assert process.poll() is None, "the command ended by itself"
        time.sleep(0.05)
    raise AssertionError("the fleet did not start")
