"""A robot and a world that is not there: before the first word, during a run, after it."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from agents.node import PATIENCE, RobotNode
from deploy.library.load import load
from deploy.run.local import LocalFleet
from protocol.bus.local import LocalNetwork
from protocol.errors import BusError
from world.node import WorldNode
from world.shell.journal import Journal

SCENARIO = load("swap-2")


def test_without_a_world_a_robot_waits_as_long_as_asked_and_no_longer() -> None:
    network = LocalNetwork()
    bus = network.connect()
    bus.node = RobotNode(bus, "yard", 1, wait=0.3)
    began = time.monotonic()
    with pytest.raises(BusError, match="no world answers"):
        network.run(lambda: False)
    assert 0.3 <= time.monotonic() - began < PATIENCE


def test_a_robot_that_is_there_first_joins_a_world_that_comes_later() -> None:
    network = LocalNetwork()
    began = time.monotonic()
    for robot in SCENARIO.ids:
        bus = network.connect()
        bus.node = RobotNode(bus, "yard", robot)
    network.run(lambda: time.monotonic() > began + 0.3)
    bus = network.connect()
    world = bus.node = WorldNode(bus, "yard", [SCENARIO])
    network.run(lambda: world.finished)
    assert world.report is not None
    assert world.report["verdict"] == "arrived"


@pytest.mark.parametrize("journalled", [False, True])
def test_a_run_that_is_over_is_left_unless_its_world_may_be_back(journalled: bool, tmp_path: Path) -> None:
    path = tmp_path / "journal" if journalled else None
    if path is not None:
        Journal.create(path, "local", [SCENARIO])
    fleet = LocalFleet([SCENARIO], journal=path)
    robots = [bus.node for bus in fleet.robots.values()]
    fleet.network.run(lambda: fleet.world.report is not None)  # not all know it yet
    fleet.kill_world()
    until = time.monotonic() + 0.3
    fleet.network.run(lambda: time.monotonic() > until)
    assert all(robot is not None and robot.finished for robot in robots) is not journalled
    if journalled:
        fleet.start_world()
        fleet.execute()
        fleet.network.run(lambda: all(robot is not None and robot.finished for robot in robots))
