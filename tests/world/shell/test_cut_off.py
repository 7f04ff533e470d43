"""A world by hand, or of several hosts, goes on with robots that were cut off and are back."""

import time
from collections.abc import Callable
from unittest.mock import Mock

import pytest
import typer

from deploy.cli import node as by_hand
from deploy.library.load import load
from deploy.run.assembly import Assembly
from deploy.run.local import LocalFleet
from tests.skipped_waits import skipped_waits
from tests.system.orders.turnover import step
from world import process
from world.shell.node import WorldNode

SWAP = load("swap-4")


def of_hand(monkeypatch: pytest.MonkeyPatch) -> int:
    main = Mock(return_value=0)
    monkeypatch.setattr(process, "main", main)
    monkeypatch.setattr(by_hand, "begin", Mock())
    monkeypatch.setattr(by_hand, "set_process_title", Mock())
    with pytest.raises(typer.Exit):
        by_hand.world(SWAP.name, run="yard", router="tcp/127.0.0.1:7447")
    return main.call_args.kwargs["restarts"]


def of_hosts(_: pytest.MonkeyPatch) -> int:
    assembly = Mock(_options=Mock(restarts=0), _record=None)
    Assembly._start_world(assembly, None)
    ((row,),) = assembly.supervisor.start.call_args.args
    return row.arguments[6]


def run(fleet: LocalFleet, seconds: float) -> None:
    end = time.monotonic() + seconds
    fleet.network.run(lambda: fleet.world.finished or time.monotonic() > end)


@pytest.mark.parametrize(("restarts", "lockstep"), [(of_hand, False), (of_hosts, True)])
def test_all_robots_may_be_cut_off_for_some_seconds(
    restarts: Callable[[pytest.MonkeyPatch], int], lockstep: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    lives = restarts(monkeypatch)

    class Fleet(LocalFleet):
        def _world(self, bus, _=None) -> WorldNode:
            return WorldNode(bus, self.run, SWAP, lockstep, restarts=lives, on_report=self.report.update)

    with skipped_waits():
        fleet = Fleet(SWAP, lockstep=lockstep)
        step(fleet, 10)
        for robot, bus in fleet.robots.items():
            fleet.pause(robot)
            fleet.network.publish_presence(bus.announced[0], False, bus)
        run(fleet, 5.0)
        for robot, bus in fleet.robots.items():
            fleet.network.publish_presence(bus.announced[0], True, bus)
            fleet.resume(robot)
        run(fleet, 300.0)
    assert fleet.report["verdict"] == "arrived"
