"""Processes of robots that were removed, or of runs that are over: each is told so, takes no other's place,
keeps no robot waiting, and no trajectory shows it."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest

from deploy.run.local import LocalFleet
from protocol.bus.bus import Presence
from protocol.joining import Admission, Finished, Reply, Wait
from protocol.scenario.model import Order, ProcessFault
from tests.skipped_waits import skipped_waits
from tests.system.faults.stale import (
    AGAIN,
    ENDLESS,
    Overheard,
    answer,
    deafen_launcher,
    deafened,
    go,
    kept,
    life,
    status,
)
from tests.system.orders.guests import GUEST, SWAP
from tests.system.orders.turnover import asked
from tests.world.driving import token


@pytest.mark.parametrize("death", ["", "appearing", "standing", "later"])
def test_a_deaf_process_of_a_removed_robot_is_not_the_next_ones(tmp_path: Path, death: str) -> None:
    """Whether or not the world dies, when the next disk is to appear, or is there, or later."""
    fleet = kept(tmp_path, ENDLESS)
    deafen_launcher(fleet)
    go(fleet, 12)
    _, node = deafened(fleet, lambda: asked(fleet, {"remove": 2}))
    session = node._world.session
    go(fleet, 1)
    assert asked(fleet, {"add": AGAIN}).accepted
    assert answer(fleet, session) == Finished("removed")
    assert isinstance(answer(fleet, "next"), Wait)  # its disk has not appeared
    for moment, ticks in (("appearing", 3), ("standing", 1), ("later", 8)):
        if moment == "later":
            go(fleet, 5)
        if death == moment:
            fleet.kill_world()
            fleet.start_world()
        go(fleet, ticks)
    assert status(fleet) == "standing"
    assert answer(fleet, session) == Finished("removed")
    fleet.world.handle(Presence(token(fleet.network, 2), False))
    assert isinstance(answer(fleet, "next"), Admission)
    assert answer(fleet, session) == Finished("removed")


def test_the_next_one_does_not_wait_for_the_token_of_the_one_before() -> None:
    fleet = LocalFleet(ENDLESS)
    deafen_launcher(fleet)
    go(fleet, 10)
    bus, _ = deafened(fleet, lambda: asked(fleet, {"remove": 2}))
    go(fleet, 1)
    assert asked(fleet, {"add": AGAIN}).accepted
    go(fleet, 4)
    successor = fleet.start(2)
    successor.wake(math.inf)
    go(fleet, 20)
    assert (status(fleet), life(fleet).joined) == ("live", True)
    bus.close()  # the token that goes is not that of the successor
    go(fleet, 20)
    assert (status(fleet), life(fleet).joined) == ("live", True)
    assert fleet.world.world.coordinator.lives.given_up == []


def test_a_late_farewell_makes_nobody_wait_for_the_next() -> None:
    fleet = LocalFleet(ENDLESS)
    deafen_launcher(fleet)
    fleet.world._failures._restarts = 1
    go(fleet, 10)
    bus, _ = deafened(fleet, lambda: asked(fleet, {"remove": 2}))
    go(fleet, 1)
    assert asked(fleet, {"add": AGAIN}).accepted
    go(fleet, 4)
    bus.close()
    before = fleet.world.world.tick
    go(fleet, 20)
    assert fleet.world.world.tick - before >= 20
    assert not fleet.world._failures.expected  # no robot was waited for


def test_a_stranger_that_asks_for_a_removed_robot_keeps_its_process_from_nothing() -> None:
    """It asks while the world waits for another robot, before that process could be told."""
    orders, faults = (Order(0.5, remove=2), Order(1.0, add=AGAIN)), (ProcessFault(3, 0.5, "restart"),)
    scenario, found = replace(SWAP, orders=orders, process=faults), []
    for stranger in (False, True):
        with skipped_waits():
            fleet, told = LocalFleet(scenario), list[Reply]()
            ears, world = Overheard(fleet), fleet.world.world
            ears.when = lambda world=world, fleet=fleet: (  # type: ignore[misc]
                status(fleet) == "gone" and not world.is_open
            )
            if stranger:
                ears.then = lambda fleet=fleet, told=told: told.append(  # type: ignore[misc]
                    answer(fleet, "stranger")
                )
            report = fleet.execute()
        assert len(told) == stranger
        found.append((report["verdict"], report["faults"]["given_up"], report["trajectory_sha256"]))
    assert found[0] == found[1]


def test_who_comes_while_its_robot_is_gone_waits_if_that_is_to_come_again() -> None:
    comings = Order(0.2, add=GUEST), Order(1.0, remove=7), Order(1.3, add=GUEST)
    fleet = LocalFleet(replace(SWAP, orders=comings))
    fleet.network.run(lambda: fleet.world.world.tick >= 22 or fleet.world.finished)
    assert status(fleet, 7) == "gone"
    assert isinstance(answer(fleet, "next", 7), Wait)
    before = fleet.world._admissions.processes.newest[7]
    assert answer(fleet, before, 7) == Finished("removed")
    fleet.network.run(lambda: fleet.world.world.tick >= 27 or fleet.world.finished)
    assert status(fleet, 7) != "gone"
