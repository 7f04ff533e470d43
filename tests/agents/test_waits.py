"""A robot and a world that is not there: before the first word, during a run, after it."""

import time
from dataclasses import replace
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
from protocol.messages import State, Tick
from protocol.scenario.model import ProcessFault
from protocol.scenario.network import Network
from tests.mortal import MortalFleet
from tests.skipped_waits import skipped_waits
from tests.world.driving import token
from world.shell.node import WorldNode

SCENARIO = load("swap-2")


@skipped_waits()
def test_without_a_world_a_robot_waits_as_long_as_asked_and_no_longer() -> None:
    network = LocalNetwork()
    bus = network.connect()
    bus.node = RobotNode(bus, "yard", 1, wait=0.3)
    began = time.monotonic()
    with pytest.raises(BusError, match="no world answers"):
        network.run(lambda: False)
    assert 0.3 <= time.monotonic() - began < PATIENCE


@pytest.mark.parametrize("kept", [False, True])
@skipped_waits()
def test_a_run_that_is_over_is_left_unless_its_world_may_be_back(kept: bool, tmp_path: Path) -> None:
    fleet = MortalFleet(SCENARIO, tmp_path / "checkpoint" if kept else None)
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


def test_a_robot_that_asks_a_world_that_leaves_hears_that_it_has_left(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A question keeps a robot from hearing anything: at the end of a run it is short."""
    fleet, waited = LocalFleet(SCENARIO), list[float]()
    fleet.network.run(lambda: fleet.world.world.tick > 10)
    node = fleet.robots[1].node

    def ask(_: LocalBus, __: str, ___: bytes, timeout: float) -> list[bytes]:
        waited.append(timeout)
        raise BusError("no answer")

    monkeypatch.setattr(LocalBus, "ask", ask)
    over = Tick(1, 1, node.core.tick, (), epoch=node.core.epoch, over=True)
    node.handle(Sample(robot_key("local", 1, "tick"), encode(over)))
    node.on_timer(time.monotonic())
    assert 0.0 < sum(waited) < 0.5, "the launcher ends processes that have not left after 2 s"
    assert not node.finished, "the world may be busy"
    later = Tick(1, 1, over.tick + 1, (), epoch=over.epoch)
    node.handle(Sample(robot_key("local", 1, "tick"), encode(later)))
    assert node.core.tick == over.tick, "this life is over"
    node.handle(Presence(token(fleet.network), False))
    assert node.finished


@pytest.mark.parametrize("missed", [False, True])
@skipped_waits()
def test_a_robot_that_was_cut_off_before_the_run_began_asks_whether_it_still_takes_part(missed: bool) -> None:
    network = LocalNetwork()
    bus = network.connect()
    world = bus.node = WorldNode(bus, "yard", SCENARIO, gathering=5.0)
    bus = network.connect()
    first = bus.node = RobotNode(bus, "yard", 1)
    network.run(lambda: world.world.lives.awaited == {2})
    tokens = token(network, 1), token(network)
    for there in (False, True):  # its link was out, perhaps for longer than the world's patience
        if missed:
            world.handle(Presence(tokens[0], there))
        first.handle(Presence(tokens[1], there))
    life = first.core
    first.on_timer(first.deadline)
    assert (first._world.back, first.core is life) == (False, not missed), "it has asked, once"
    bus = network.connect()
    bus.node = RobotNode(bus, "yard", 2)
    network.run(lambda: world.finished)
    assert world.report["verdict"] == "arrived"


def test_what_is_of_another_life_or_tick_leaves_the_present_one_as_it_is() -> None:
    fleet = LocalFleet(load("swap-4"))
    while fleet.world.world.tick < 3:
        fleet.step()
    node = fleet.robots[1].node
    core = node.core
    core.incarnation = 2  # a life of this process began within the tick
    fleet.world_bus.node = None
    core.inbox.is_open = True
    core.inbox._awaited = {2, 3, 4}
    node.handle(Sample(robot_key("local", 1, "tick"), encode(Tick(1, 1, core.tick, (1, 2), core.epoch))))
    assert core.inbox.missing == [2, 3, 4]
    node.handle(Sample(robot_key("local", 1, "tick"), encode(Tick(1, 2, core.tick, (1, 2), core.epoch))))
    assert core.inbox.missing == [2]
    node.handle(Sample(robot_key("local", 1, "tick"), encode(Tick(1, 2, 0, (1, 2), core.epoch))))
    assert core.tick > 0, "an older one of this life begins nothing"
    bus = fleet.network.connect()
    bus.subscribe(robot_key("local", 1, "command"))
    core.inbox.close()
    early = State(2, 1, core.tick + 1, None, 0.0, 0.0, 0.0, (0.0, 0.0), core.epoch)
    node.handle(Sample(robot_key("local", 2, "state"), encode(early)))
    assert (core.inbox.complete, bus.receive(0.0)) == (True, None), "its Command is out"
    now, tick = time.monotonic(), core.tick
    node._world.heard, node._due = now - PATIENCE, now + PATIENCE
    node.handle(Sample(robot_key("local", 1, "tick"), encode(Tick(1, 3, tick + 1, (1, 2), core.epoch))))
    assert core.tick == tick, "it is another process's, which has taken its place"
    assert now <= node._world.heard <= node.deadline <= time.monotonic(), "it asks at once"


def test_a_robot_that_missed_an_approach_does_not_wait_for_gone_peers() -> None:
    """A Tick that names no robot means those that the world named last, and the robot does the same."""
    base, ids = load("random-14"), (1, 4, 5, 8, 10, 12, 13)
    scenario = replace(
        base,
        robots=tuple(spec for spec in base.robots if spec.id in ids),
        network=Network("near", 0.1),
        process=tuple(
            ProcessFault(robot, tick * 0.05, event)
            for robot, tick, event in ((1, 42, "pause"), (5, 47, "kill"), (1, 50, "resume"))
        ),
        time=replace(base.time, limit=4.0),
    )
    with skipped_waits(), LocalFleet(scenario) as fleet:
        assert fleet.execute()["faults"]["given_up"] == []


@skipped_waits()
def test_every_life_says_once_what_troubles_it(caplog: pytest.LogCaptureFixture) -> None:
    faults = ProcessFault(1, 0.5, "pause"), ProcessFault(1, 5.0, "resume")
    fleet = LocalFleet(replace(SCENARIO, process=faults))
    node = fleet.robots[1].node
    for life in (1, 2):
        fleet.network.run(lambda life=life: node.core is not None and node.core.incarnation == life)
        node.core._estimate.contradiction = "two measurements exclude each other"
        fleet.network.run(lambda: node.core.tick >= 0 and node.core.inbox.is_open)
        begun = node.core.tick
        fleet.network.run(lambda begun=begun: node.core.tick > begun + 2)
    assert caplog.messages == ["robot-1: two measurements exclude each other; stands still"] * 2
