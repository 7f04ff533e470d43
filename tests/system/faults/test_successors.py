"""The process of a robot while routers and worlds come and go: neither the process that a successor is to
replace nor a stranger, and no trajectory shows it."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from pathlib import Path

import pytest

from agents.shell.node import RobotNode
from deploy.run.fleet import Fleet
from deploy.run.launcher import Launcher
from deploy.run.local import LocalFleet
from deploy.run.options import RunOptions
from protocol.bus.bus import Presence
from protocol.joining import Admission, Refusal
from protocol.scenario.model import ProcessFault
from tests.system.faults.stale import (
    ENDLESS,
    RESTARTED,
    Overheard,
    answer,
    deafen_launcher,
    go,
    kept,
    life,
)
from tests.system.orders.guests import SWAP
from tests.world.driving import token


def blink(fleet: LocalFleet) -> None:
    """The router goes and comes back: so do all tokens."""
    for alive in (False, True):
        for robot, bus in fleet.robots.items():
            fleet.world.handle(Presence(token(fleet.network, robot), alive))
            assert bus.node is not None
            bus.node.handle(Presence(token(fleet.network), alive))


@pytest.fixture(scope="module")
def undisturbed() -> str:
    sha: str = LocalFleet(RESTARTED).execute()["trajectory_sha256"]
    return sha


@pytest.mark.slow
def test_who_is_to_be_restarted_is_not_its_own_successor_when_a_router_goes(
    tmp_path: Path, undisturbed: str
) -> None:
    """Its launcher gets to it late, and it asks what became of it."""
    fleet, faults = kept(tmp_path), list[ProcessFault]()
    fleet.launcher.carry_out = faults.append  # type: ignore[method-assign]
    fleet.network.run(lambda: bool(faults))
    blink(fleet)
    go(fleet, 1, seconds=0.5)
    assert (fleet.world.world.tick, life(fleet).incarnation) == (10, 1)
    for fault in faults:
        Launcher.carry_out(fleet.launcher, fault)
    report = fleet.execute()
    assert (report["trajectory_sha256"], report["faults"]["given_up"]) == (undisturbed, [])


def test_a_successor_that_is_heard_before_the_world_is_itself_again_is_no_victim(tmp_path: Path) -> None:
    """The world died as the tick of the restart opened, when its launcher had heard of it."""
    fleet = kept(tmp_path)
    deafen_launcher(fleet)
    dead, ears = list[bool](), Overheard(fleet)
    ears.when = lambda: not life(fleet).joined and fleet.world.world.tick == 10
    ears.then = lambda: dead.append(True)
    fleet.network.run(lambda: bool(dead))
    fleet.kill_world()
    fleet.kill(2)
    successor = fleet.start(2)
    fleet.start_world()
    successor.wake(math.inf)
    deadline = time.monotonic() + 10.0
    fleet.network.run(lambda: fleet.world.finished or time.monotonic() > deadline)
    report = fleet.world.report
    assert report is not None
    assert (report["verdict"], report["faults"]["given_up"], report["worlds"]) == ("arrived", [], [10])


def test_nobody_takes_the_seat_of_a_process_that_is_there_when_the_world_comes_back(tmp_path: Path) -> None:
    fleet = kept(tmp_path, ENDLESS)
    deafen_launcher(fleet)
    go(fleet, 10)
    fleet.world.world.coordinator.lost(2, "hangs")
    assert not life(fleet).goes_on
    node = fleet.robots[2].node
    assert isinstance(node, RobotNode)
    assert isinstance(answer(fleet, "stranger"), Refusal)
    fleet.kill_world()
    fleet.start_world()
    fleet.world_bus.drain()  # the tokens
    assert isinstance(answer(fleet, "stranger"), Refusal)
    assert isinstance(answer(fleet, node._world.session), Admission)


@pytest.mark.process
@pytest.mark.timeout(120)
@pytest.mark.long(7)
def test_who_is_frozen_for_longer_than_its_token_lives_goes_on() -> None:
    """At any speed: a token lives for two seconds."""
    faults = (ProcessFault(2, 0.2, "pause"), ProcessFault(2, 3.2, "resume"))
    scenario = replace(SWAP, process=faults, time=replace(SWAP.time, fence=6.0, limit=4.5))
    with Fleet(scenario, RunOptions("routed", speed=1.0)) as fleet:
        report = fleet.execute()
    assert (report["verdict"], report["down"], report["faults"]["given_up"]) == ("timeout", [], [])
    assert report["trajectory_sha256"] == LocalFleet(scenario).execute()["trajectory_sha256"]
