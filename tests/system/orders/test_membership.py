"""Robots that come and go while the fleet runs: announced, cleared, put down, joined, removed."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest

from deploy.library.load import load
from deploy.run.fleet import Fleet
from deploy.run.local import LocalFleet
from deploy.run.operator import operating
from deploy.run.options import RunOptions
from protocol.bus.connection import Connection
from protocol.messages import Clock
from protocol.operations import Reply
from protocol.scenario.body import Body
from protocol.scenario.model import Operation, Order, RobotSpec
from tests.system.orders.guests import GUEST, SWAP, status, step, to_be
from tests.system.orders.turnover import asked
from world.report import result_of

COMINGS = [(0.2, {"add": GUEST}), (1.0, {"remove": 7}), (1.3, {"add": GUEST})]
AT_ONCE = replace(SWAP, orders=tuple(Order(at, **order) for at, order in COMINGS))


def guested(tick: int, seed: int = 0) -> dict[str, Any]:
    """The report of a run that takes in a guest at a tick."""
    fleet = LocalFleet(replace(SWAP, seed=seed))
    step(fleet, tick)
    assert asked(fleet, {"add": GUEST}).accepted
    return fleet.execute()


def test_a_guest_appears_joins_and_arrives() -> None:
    report = guested(20)
    assert (report["verdict"], report["collisions"]) == ("arrived", 0)
    assert report["robots"] == [1, 2, 3, 4, 7]
    assert math.dist(report["positions"]["7"], GUEST.goal) <= SWAP.time.tolerance
    assert report["min_clearance"] > 0.0


def test_who_is_removed_and_added_again_at_once_has_a_process_of_its_own() -> None:
    """Also if the ticks between are so few, or so quick, that no Clock lists the newcomers."""
    report = LocalFleet(AT_ONCE).execute()
    assert (report["verdict"], report["collisions"]) == ("arrived", 0)
    assert report["faults"]["given_up"] == []  # no process was waited for in vain


def test_nothing_appears_while_somebody_is_in_its_place() -> None:
    fleet = LocalFleet(replace(SWAP, time=replace(SWAP.time, endless=True)))
    step(fleet, 5)
    (x, y), *_ = fleet.world.world.truth.positions
    assert asked(fleet, {"add": replace(GUEST, start=(x, y), goal=(x, y))}).accepted
    step(fleet, 1)
    assert status(fleet, 7) == "appearing"
    to_be(fleet, 7, "live")  # the present robots make room
    assert result_of(fleet.world.world)["collisions"] == 0


def test_who_is_removed_ends_and_may_come_back() -> None:
    fleet = LocalFleet(replace(SWAP, time=replace(SWAP.time, endless=True)))
    step(fleet, 20)
    node = fleet.robots[2].node
    assert asked(fleet, {"remove": 2}).accepted
    step(fleet, 5)
    assert (status(fleet, 2), fleet.world.world.truth.robots) == ("gone", (1, 3, 4))
    assert (node.finished, node.verdict) == (True, "removed")
    assert asked(fleet, {"add": RobotSpec(2, 0.02, (0.0, -0.2), (0.1, -0.2))}).accepted
    to_be(fleet, 2, "live")
    step(fleet, 40)
    report = result_of(fleet.world.world)
    assert (report["collisions"], report["robots"]) == (0, [1, 2, 3, 4])
    assert math.dist(report["positions"]["2"], (0.0, -0.2)) > 0.01  # it moves again


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"add": replace(GUEST, id=1)}, "robot 1 is live"),
        ({"add": replace(GUEST, start=(0.43, 0.0))}, "out of the workspace"),
        ({"add": replace(GUEST, goal=(0.0, -0.5))}, "out of the workspace"),
        ({"add": replace(GUEST, radius=-1.0)}, "add.radius: must be at least 1e-09"),
        ({"add": replace(GUEST, start=(math.nan, 0.0))}, "add.start[0]: must be a finite"),
        ({"add": replace(GUEST, heading=math.nan)}, "add.heading: must be a finite"),
        (
            {"add": replace(GUEST, body=Body("omnidirectional", acceleration=-1.0))},
            "add.body.acceleration: must be at least",
        ),
        (
            {"add": replace(GUEST, body=Body("differential-drive", offset=0.01))},
            "body.track: must be above 0",
        ),
        ({"add": replace(GUEST, body=Body(radius=0.05))}, "radius: must be at least 0.05"),
        ({"add": replace(GUEST, body=Body(error=0.1))}, "points only"),
        ({"remove": 9}, "no robot 9 in the fleet; there are 1, 2, 3, 4"),
    ],
)
def test_what_cannot_be_is_refused_by_reason_and_changes_nothing(change: dict[str, Any], reason: str) -> None:
    fleet = LocalFleet(SWAP)
    step(fleet, 3)
    before = asked(fleet).roster
    reply = asked(fleet, change)
    assert not reply.accepted
    assert reason in reply.text
    assert reply.roster == before


def test_the_last_one_stays() -> None:
    fleet = LocalFleet(replace(SWAP, time=replace(SWAP.time, endless=True)))
    step(fleet, 3)
    for robot in (1, 2, 3):
        assert asked(fleet, {"remove": robot}).accepted
        step(fleet, 2)
    assert "is the last one" in asked(fleet, {"remove": 4}).text


class Guests:
    """Takes a guest in at tick 10, and out again once it has been live for a while."""

    def __init__(self) -> None:
        self.told: list[Reply] = []
        # To those of the beginning: the guest may not be there yet.
        self._connection: Connection | None = None

    def __call__(self, fleet: Fleet, clock: Clock) -> None:
        self._connection = self._connection or fleet.topology.observer()
        comes, goes = clock.tick >= 10 and not self.told, len(self.told) == 1 and 7 in clock.active
        if comes or goes:
            with operating(self._connection, fleet._options.run) as operator:
                self.told.append(operator.operate(Operation(add=GUEST) if comes else Operation(remove=7)))


@pytest.mark.process
@pytest.mark.timeout(120)
def test_processes_come_and_go() -> None:
    guests, clocks = Guests(), list[Clock]()
    scenario = replace(load("swap-6"), time=replace(SWAP.time, limit=60.0))
    with Fleet(scenario, RunOptions(speed=4.0), watch=clocks.append) as fleet:

        def enough() -> bool:
            while clocks:
                guests(fleet, clocks.pop(0))
            return False

        report = fleet.execute(enough)
        rows = {row["name"]: row for row in fleet.processes()}
    assert [reply.accepted for reply in guests.told] == [True, True]
    assert (report["verdict"], report["collisions"]) == ("arrived", 0)
    assert rows["robot-7"]["exit_code"] == 0
