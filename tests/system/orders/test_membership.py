"""Robots that come and go while the fleet runs: announced, cleared, put down, joined, removed."""

import math
from dataclasses import replace
from typing import Any

import pytest

from deploy.library.load import resolved
from deploy.run.local import LocalFleet
from protocol.scenario.body import Body
from protocol.scenario.model import Order, ProcessFault, RobotSpec, Scenario, Time, Workspace
from tests.campaigns.observe import observe
from tests.skipped_waits import skipped_waits
from tests.system.orders.turnover import ENDLESS, GUEST, GUESTED, SWAP, asked, status, step, to_be
from world.report import result_of


def test_nothing_appears_while_somebody_is_in_its_place() -> None:
    fleet = LocalFleet(ENDLESS)
    step(fleet, 5)
    (x, y), *_ = fleet.world.world.truth.positions
    assert asked(fleet, {"add": replace(GUEST, start=(x, y), goal=(x, y))}).accepted
    step(fleet, 1)
    assert status(fleet, 7) == "appearing"
    to_be(fleet, 7, "live")  # the present robots make room
    assert result_of(fleet.world.world)["collisions"] == 0


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"add": replace(GUEST, id=1)}, "robot 1 is live"),
        ({"add": replace(GUEST, start=(0.43, 0.0))}, "out of the workspace"),
        ({"add": replace(GUEST, goal=(0.0, -0.5))}, "out of the workspace"),
        ({"add": replace(GUEST, start=(math.nan, 0.0))}, "add.start[0]: must be a finite"),
        ({"add": replace(GUEST, body=Body("differential-drive"))}, "body.offset: must be above 0"),
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
    fleet = LocalFleet(ENDLESS)
    step(fleet, 3)
    for robot in (1, 2, 3):
        assert asked(fleet, {"remove": robot}).accepted
        step(fleet, 2)
    assert "is the last one" in asked(fleet, {"remove": 4}).text


@skipped_waits()
def test_a_process_that_is_there_before_its_order_waits_and_no_trajectory_shows_it() -> None:
    fleet = LocalFleet(GUESTED)
    process = fleet.start(7)
    for _ in range(10):
        process.on_timer(math.inf)  # asks to join: a process that is refused repeatedly gives up
    report = fleet.execute()
    assert (report["verdict"], report["robots"]) == ("arrived", [1, 2, 3, 4, 7])
    assert report["trajectory_sha256"] == LocalFleet(GUESTED).execute()["trajectory_sha256"]
    assert fleet.robots[7].node is process
    assert process.verdict == "arrived"


def test_a_process_that_waits_for_an_order_that_never_comes_is_told_so() -> None:
    fleet = LocalFleet(replace(GUESTED, time=replace(SWAP.time, limit=0.15)))
    process = fleet.start(7)
    process.on_timer(math.inf)
    report = fleet.execute()
    assert (report["verdict"], report["faults"]["given_up"]) == ("timeout", [])
    process.on_timer(math.inf)
    assert process.verdict == "timeout"


@pytest.mark.slow
def test_a_guest_that_appears_as_the_run_ends_is_told_that_it_is_over() -> None:
    """A robot that was removed while it was paused keeps the world waiting for what it reports."""
    orders = (Order(0.0, add=GUEST), Order(0.0, remove=2))
    pause = (ProcessFault(2, 0.0, "pause"),)
    for limit in range(1, 6):
        time_ = replace(SWAP.time, limit=limit * SWAP.time.step)
        with skipped_waits():
            fleet = LocalFleet(replace(SWAP, time=time_, orders=orders, process=pause))
            assert fleet.execute()["verdict"] == "timeout"


@pytest.mark.slow
def test_no_fault_that_the_world_passes_over_ends_the_process_of_the_next_robot() -> None:
    """However late a launcher gets to the first: robot 2 is not there, and its next process comes."""
    specs = RobotSpec(1, 0.3, (0.0, 1.0), (0.0, 0.0)), RobotSpec(2, 0.3, (0.0, 0.0), (0.0, -1.0))
    faults = ProcessFault(2, 0.04, "restart"), ProcessFault(2, 0.053, "restart")
    orders = Order(0.0, remove=2), Order(0.05, add=RobotSpec(2, 0.09, (0.0, 0.0), (0.0, 1.0)))
    time_, room = Time(step=0.05, limit=0.3), Workspace(3.0)
    scenario = resolved(Scenario(specs, workspace=room, time=time_, process=faults, orders=orders))
    calm = observe(scenario)
    assert calm.report["faults"]["given_up"] == []
    assert [fault["tick"] for fault in calm.report["faults"]["process"]] == [2]
    assert {observe(scenario, busy=seed).trajectory for seed in (1, 2)} == {calm.trajectory}
