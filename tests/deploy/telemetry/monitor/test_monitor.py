"""Watchers in the process of the fleet, played recordings, and the terminal table."""

from __future__ import annotations

import io
import time
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from typing import Any

import pytest
from rich.console import Console

from deploy.run.local import LocalFleet
from deploy.telemetry.monitor import terminal
from deploy.telemetry.monitor.watcher import Player, Watcher
from protocol.bus.local import LocalNetwork
from protocol.keys import parse
from protocol.messages import Clock, Truth
from protocol.operations import Steer
from protocol.scenario.model import Journey, Operation, Order, Point, RobotSpec, Time
from protocol.streams import STREAMS
from tests.deploy.telemetry.monitor.watched import PATIENCE, ring, running, until, watch_local
from tests.system.orders.turnover import asked


def test_a_watcher_sees_what_the_world_judged() -> None:
    fleet = LocalFleet(ring(), "r")
    watcher = watch_local(fleet.network, "r")
    report = fleet.execute()
    frame = watcher.snapshot()
    assert frame["verdict"] == report["verdict"] == "arrived"
    assert frame["tick"] == report["ticks"]
    assert frame["smallest"] >= report["min_clearance"] - 1e-12
    assert {row["status"] for row in frame["robots"]} == {"at goal"}
    assert watcher.overview()["history"][-1][2] == pytest.approx(report["log_potential"]["last"])


@pytest.mark.slow
def test_a_watcher_does_not_change_a_run() -> None:
    alone, watched = LocalFleet(ring(), "r"), LocalFleet(ring(), "r")
    watch_local(watched.network, "r")
    assert alone.execute()["trajectory_sha256"] == watched.execute()["trajectory_sha256"]


def test_robots_are_shown_while_they_are_there() -> None:
    """Whom orders of the scenario add, and whom an operator does: of them the world is asked."""
    guests = RobotSpec(5, 0.02, (0.17, 0.17), (0.18, 0.16)), RobotSpec(7, 0.02, (0.17, -0.17), (0.16, -0.18))
    scenario = replace(ring(), time=Time(endless=True), orders=(Order(0.2, add=guests[0]),))
    fleet = LocalFleet(scenario, "r")
    watcher = watch_local(fleet.network, "r")

    def shows(*robots: int) -> bool:
        assert fleet.step()
        watcher.wake(time.monotonic())
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


def test_a_watcher_hears_only_what_the_network_may_drop() -> None:
    class Listening:
        def __init__(self) -> None:
            self.heard: list[str] = []

        def subscribe(self, key_expression: str) -> None:
            self.heard.append(key_expression)

        def watch(self, key_expression: str) -> None:
            pass

    bus = Listening()
    Watcher(bus, "r")  # type: ignore[arg-type]  # a bus that only listens is all it needs here
    streams = [parse(key.replace("*", "1")).stream for key in bus.heard]
    assert streams
    assert not [stream for stream in streams if STREAMS[stream].reliable]


def test_who_comes_late_is_shown_what_is_in_force() -> None:
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


def sent(*points: Point) -> Operation:
    return Operation(goal=Journey(1, points))


def test_a_run_that_does_not_answer_an_order_is_a_refusal() -> None:
    watcher = watch_local(LocalNetwork(), "r")
    watcher._known = True  # what it learnt once; the world has gone since
    answer, stop = watcher.operate(sent((0.0, 0.0))), watcher.operate(Operation(halt=True))
    watcher.wake(time.monotonic())
    assert "no answer" in answer.result(0.0).text
    assert "no answer" in stop.result(0.0).text


@pytest.mark.slow
def test_an_emergency_stop_reaches_the_run_and_its_release_too() -> None:
    fleet = LocalFleet(ring(), "r")
    watcher = watch_local(fleet.network, "r", speed=1.0)
    assert "no run yet" in watcher.operate(Operation(halt=True)).result(0.0).text
    with running(fleet):
        until(lambda: watcher.snapshot()["tick"] >= 2)
        assert watcher.operate(Operation(halt=True)).result(PATIENCE).accepted
        until(lambda: watcher.snapshot()["phase"] == "halted")
        stood = fleet.world.world.truth.positions
        tick = fleet.world.world.tick
        until(lambda: fleet.world.world.tick >= tick + 5)
        assert fleet.world.world.truth.positions == stood
        assert watcher.operate(Operation(halt=False)).result(PATIENCE).accepted
        watcher.steer(Steer(speed=0.0))
        until(lambda: watcher.snapshot()["verdict"] == "arrived")


def entries(ticks: int) -> Iterator[tuple[float, Clock | Truth]]:
    for tick in range(ticks):
        yield 0.05 * tick, Clock(tick, 0.05 * tick, (1, 2), (), "")
        yield 0.05 * (tick + 1), Truth(tick + 1, (1, 2), ((0.0, 0.0), (0.1, 0.1)), 0.01, 0.5)
    yield 0.05 * ticks, Clock(ticks, 0.05 * ticks, (), (), "arrived")


def test_a_recording_plays_at_its_speed_and_can_be_held() -> None:
    with closing(Player(ring(2), "old", entries(400), speed=1.0)) as player:
        until(lambda: player.snapshot()["tick"] >= 2)
        player.steer(Steer(pause=True))
        held = player.snapshot()
        assert held["phase"] == "paused"
        assert not player.join(0.15)
        assert player.snapshot()["tick"] <= held["tick"] + 1
        player.steer(Steer(pause=False, speed=0.0))
        assert "recording" in player.operate(sent()).result(0.0).text
        assert "recording" in player.operate(Operation(halt=True)).result(0.0).text
        assert player.join(PATIENCE)
        assert player.snapshot()["verdict"] == "arrived"


def test_the_terminal_shows_the_same_rows_and_ends_with_the_run() -> None:
    player = Player(ring(2), "old", entries(3), speed=0.0)
    console = Console(record=True, width=120, file=io.StringIO())
    assert terminal.show(player, console) == "arrived"
    player.close()
    frame = player.snapshot()
    frame["robots"][0].update(alarm=True, status="fenced")
    text = rendered(frame)
    assert "✕ fenced" in text
    assert "smallest clearance 10.00 mm" in text


def rendered(frame: dict[str, Any]) -> str:
    console = Console(record=True, width=120, file=io.StringIO())
    console.print(terminal.table(frame))
    return console.export_text()
