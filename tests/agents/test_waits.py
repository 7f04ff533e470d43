"""A robot and a world that is not there: before the first word, during a run, after it."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from agents.shell.node import RobotNode
from agents.shell.world_session import PATIENCE
from deploy.library.load import load
from deploy.run.local import LocalFleet
from protocol.bus.bus import Presence, Sample
from protocol.bus.local import LocalBus, LocalNetwork
from protocol.codec import encode
from protocol.errors import BusError
from protocol.keys import robot_key
from protocol.messages import Tick
from tests.world.driving import token
from world.shell.checkpoint import Checkpoint
from world.shell.node import WorldNode

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
    world = bus.node = WorldNode(bus, "yard", SCENARIO)
    network.run(lambda: world.finished)
    assert world.report is not None
    assert world.report["verdict"] == "arrived"


@pytest.mark.parametrize("kept", [False, True])
@pytest.mark.slow
def test_a_run_that_is_over_is_left_unless_its_world_may_be_back(kept: bool, tmp_path: Path) -> None:
    path = tmp_path / "checkpoint" if kept else None
    if path is not None:
        Checkpoint.create(path)
    fleet = LocalFleet(SCENARIO, checkpoint=path)
    robots = [bus.node for bus in fleet.robots.values()]
    fleet.network.run(lambda: fleet.world.report is not None)  # not all know it yet
    fleet.kill_world()
    until = time.monotonic() + 0.3
    fleet.network.run(lambda: time.monotonic() > until)
    assert all(robot is not None and robot.finished for robot in robots) is not kept
    if kept:
        fleet.start_world()
        fleet.execute()
        fleet.network.run(lambda: all(robot is not None and robot.finished for robot in robots))


class Unanswered:
    """A bus without any answer once it is `mute`."""

    def __init__(self, bus: LocalBus) -> None:
        self._bus = bus
        self.mute, self.waited = False, 0.0

    def __getattr__(self, name: str) -> object:
        return getattr(self._bus, name)

    def ask(self, key: str, payload: bytes, timeout: float) -> list[bytes]:
        if not self.mute:
            return self._bus.ask(key, payload, timeout)
        self.waited += timeout
        raise BusError("no answer")


def test_who_asks_a_world_that_leaves_hears_that_it_has_left() -> None:
    """A question keeps a robot from hearing anything: at the end of a run it is short."""
    network = LocalNetwork()
    bus = network.connect()
    world = bus.node = WorldNode(bus, "yard", SCENARIO)
    buses = {robot: network.connect() for robot in SCENARIO.ids}
    links = {robot: Unanswered(bus) for robot, bus in buses.items()}
    nodes = {robot: RobotNode(link, "yard", robot) for robot, link in links.items()}
    for robot, bus in buses.items():
        bus.node = nodes[robot]
    network.run(lambda: world.world.tick > 10)
    links[1].mute = True
    core = nodes[1].core
    assert core is not None
    nodes[1].handle(
        Sample(
            robot_key("yard", 1, "tick"),
            encode(Tick(1, 1, world.world.tick, (), epoch=core.epoch, over=True)),
        )
    )
    nodes[1].wake(time.monotonic())
    assert 0.0 < links[1].waited < 0.5, "the launcher ends processes that have not left after 2 s"
    assert not nodes[1].finished, "the world may be busy"
    nodes[1].handle(Presence(token(network), False))
    assert nodes[1].finished


def test_a_robot_that_was_cut_off_before_the_run_began_asks_whether_it_still_takes_part() -> None:
    network = LocalNetwork()
    bus = network.connect()
    world = bus.node = WorldNode(bus, "yard", SCENARIO, gathering=5.0)
    bus = network.connect()
    first = bus.node = RobotNode(bus, "yard", 1)
    network.run(lambda: world.world.coordinator.lives.awaited == {2})
    tokens = token(network, 1), token(network)
    for there in (False, True):  # its link was out for longer than the world's patience
        world.handle(Presence(tokens[0], there))
        first.handle(Presence(tokens[1], there))
    bus = network.connect()
    bus.node = RobotNode(bus, "yard", 2)
    network.run(lambda: world.finished)
    assert world.report is not None
    assert world.report["verdict"] == "arrived"


def test_a_life_that_goes_on_does_not_notice_that_it_asked() -> None:
    network = LocalNetwork()
    bus = network.connect()
    world = bus.node = WorldNode(bus, "yard", SCENARIO)
    robots = []
    for robot in SCENARIO.ids:
        bus = network.connect()
        robots.append(RobotNode(bus, "yard", robot))
        bus.node = robots[-1]
    network.run(lambda: world.world.tick > 10)
    for there in (False, True):  # the router was gone for a moment
        for robot in robots:
            robot.handle(Presence(token(network), there))
    network.run(lambda: world.finished)
    assert world.report is not None
    assert world.report["trajectory_sha256"] == LocalFleet(SCENARIO).execute()["trajectory_sha256"]
    assert set(world.world.coordinator.lives.incarnations.values()) == {1}
