"""Watchers in the process of the fleet, played recordings, and the terminal table."""

import io
import signal
import time
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace

import pytest
from rich.console import Console

from deploy.run.fleet import Fleet
from deploy.run.local import LocalFleet
from deploy.run.options import RunOptions, fresh_run_name
from deploy.telemetry.monitor import terminal
from deploy.telemetry.monitor.watcher import Attachment, Player
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from protocol.messages import Clock, Truth
from protocol.operations import Steer
from protocol.scenario.model import Journey, Operation, Order, RobotSpec, Time
from tests.deploy.printed import printed
from tests.deploy.telemetry.monitor.watched import ring, running, watch_local
from tests.system.orders.turnover import asked
from tests.until import PATIENCE, until


def test_a_watcher_sees_what_the_world_judged_and_changes_nothing() -> None:
    fleet = LocalFleet(ring(), "r")
    watcher = watch_local(fleet.network, "r")
    report = fleet.execute()
    assert report["trajectory_sha256"] == LocalFleet(ring(), "r").execute()["trajectory_sha256"]
    frame = watcher.snapshot()
    assert frame["verdict"] == report["verdict"] == "arrived"
    assert frame["tick"] == report["ticks"]
    assert frame["smallest"] == report["min_clearance"]
    assert {row["status"] for row in frame["robots"]} == {"at goal"}
    assert watcher.overview()["history"][-1][2] == pytest.approx(report["log_potential"]["last"])


def test_robots_are_shown_while_they_are_there() -> None:
    """Robots of the orders of a scenario, and robots added by an operator, of which the world is asked."""
    guests = RobotSpec(5, 0.02, (0.17, 0.17), (0.18, 0.16)), RobotSpec(7, 0.02, (0.17, -0.17), (0.16, -0.18))
    scenario = replace(ring(), time=Time(endless=True), orders=(Order(0.2, add=guests[0]),))
    fleet = LocalFleet(scenario, "r")
    watcher = watch_local(fleet.network, "r")

    def shows(*robots: int) -> bool:
        assert fleet.step()
        watcher.on_timer(time.monotonic())
        return tuple(row["id"] for row in watcher.snapshot()["robots"]) == robots

    until(lambda: shows(1, 2, 3, 4))
    until(lambda: shows(1, 2, 3, 4, 5))
    assert asked(fleet, {"remove": 2}).accepted
    until(lambda: shows(1, 3, 4, 5))
    before = watcher.overview()
    assert asked(fleet, {"add": guests[1]}).accepted
    until(lambda: shows(1, 3, 4, 5, 7))
    after = watcher.overview()
    assert (after["robots"][-1]["goal"], after["robots"][-1]["radius"]) == (guests[1].goal, guests[1].radius)
    assert after["epoch"] == before["epoch"] + 1
    assert after["history"][: len(before["history"])] == before["history"]
    assert {row["status"] for row in watcher.snapshot()["robots"]} <= {"under way", "at goal", "joining"}


def test_a_late_viewer_is_shown_what_is_in_force() -> None:
    fleet = LocalFleet(ring(), "r", speed=1.0)
    watcher = watch_local(fleet.network, "r")
    with running(fleet):
        until(lambda: watcher.snapshot()["tick"] >= 2)
        assert watcher.snapshot()["steering"]["speed"] == 1.0
        watcher.steer(Steer(pause=True, speed=0.5))
        until(lambda: watcher.snapshot()["phase"] == "paused")
        late = watch_local(fleet.network, "r")
        until(lambda: late.snapshot()["phase"] == "paused")
        assert late.snapshot()["steering"]["speed"] == 0.5
        watcher.steer(Steer(pause=False, speed=0.0))
        until(lambda: watcher.snapshot()["verdict"] == "arrived")


def entries(ticks: int) -> Iterator[tuple[float, Clock | Truth]]:
    for tick in range(ticks):
        yield 0.05 * tick, Clock(tick, 0.05 * tick, (1, 2), (), "", 0.02)
        yield 0.05 * (tick + 1), Truth(tick + 1, (1, 2), ((0.0, 0.0), (0.1, 0.1)), 0.01, 0.5)
    yield 0.05 * ticks, Clock(ticks, 0.05 * ticks, (), (), "arrived", 0.01)


def test_a_recording_plays_at_its_speed_and_can_be_held() -> None:
    with closing(Player(ring(2), "old", entries(400), speed=1.0)) as player:
        until(lambda: player.snapshot()["tick"] >= 2)
        player.steer(Steer(pause=True))
        held = player.snapshot()
        assert held["phase"] == "paused"
        assert not player.join(0.15)
        assert player.snapshot()["tick"] <= held["tick"] + 1
        player.steer(Steer(pause=False, speed=0.0))
        assert "recording" in player.operate(Operation(goal=Journey(1, ()))).result(0.0).text
        assert "recording" in player.operate(Operation(halt=True)).result(0.0).text
        assert player.join(PATIENCE)
        assert player.snapshot()["verdict"] == "arrived"


def test_the_terminal_shows_the_same_rows_and_ends_with_the_run() -> None:
    player = Player(ring(2), "old", entries(3), speed=0.0)
    assert terminal.show(player, Console(width=120, file=io.StringIO())) == "arrived"
    player.close()
    frame = player.snapshot()
    frame["robots"][0].update(alarm=True, status="fenced")
    text = printed(terminal.table(frame))
    assert "✕ fenced" in text
    assert "smallest clearance 10.00 mm" in text


# -- from outside, over zenoh


@pytest.mark.process
@pytest.mark.timeout(90)
def test_endpoint_and_run_name_are_enough(endpoint: str) -> None:
    run, connection = fresh_run_name(), Connection(connect=(endpoint,))
    scenario = replace(ring(2), time=Time(endless=True, fence=0.2))
    with closing(Attachment(ZenohBus(connection), run)) as watcher:
        assert watcher.snapshot()["phase"] == "searching"  # the run begins later
        assert "has not started" in watcher.operate(Operation(halt=True)).result(0.0).text
        for epoch in (1, 2):  # another run of this name: everything anew
            with Fleet(scenario, RunOptions(router=endpoint, run=run, speed=2.0)) as fleet:

                def over(fleet: Fleet = fleet, epoch: int = epoch) -> bool:
                    frame = watcher.snapshot()
                    robot = frame["robots"][1] if frame["robots"] else {"alive": False, "status": ""}
                    begun = watcher.overview()["epoch"] == epoch and frame["tick"] > 3
                    if begun and robot["alive"] and "robot-2" in fleet.supervisor.running():
                        fleet.supervisor.signal("robot-2", signal.SIGKILL)
                    return begun and robot["status"] in ("dead", "fenced")

                fleet.execute(over)
                assert watcher.overview()["epoch"] == epoch
            until(lambda: watcher.snapshot()["phase"] in ("ended", "lost"))
