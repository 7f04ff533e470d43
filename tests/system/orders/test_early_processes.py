"""Processes that are there before their robots: each waits for its disk or its order, keeps no other process
waiting, and no trajectory shows it."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from agents.shell.node import RobotNode
from deploy.run.local import LocalFleet
from protocol.joining import Join, Wait
from protocol.scenario.model import Order, ProcessFault
from tests.skipped_waits import skipped_waits
from tests.system.orders.guests import GUEST, GUESTED, SWAP, status, step, to_be
from tests.system.orders.turnover import asked
from tests.world.driving import Stopwatch
from world.shell.admission import Admissions
from world.world import WorldCore


def test_a_process_that_is_there_before_its_disk_waits_for_it() -> None:
    fleet = LocalFleet(SWAP)
    step(fleet, 10)
    assert asked(fleet, {"add": GUEST}).accepted
    process = fleet.start(7)
    process.wake(math.inf)  # asks to join
    assert status(fleet, 7) == "appearing"
    to_be(fleet, 7, "standing")
    process.wake(math.inf)
    report = fleet.execute()
    assert (report["verdict"], report["robots"]) == ("arrived", [1, 2, 3, 4, 7])


@pytest.mark.slow
def test_a_process_that_is_there_before_its_order_waits_and_no_trajectory_shows_it() -> None:
    fleet = LocalFleet(GUESTED)
    process = fleet.start(7)
    for _ in range(10):
        process.wake(math.inf)  # asks to join: a process that is refused repeatedly gives up
    report = fleet.execute()
    assert (report["verdict"], report["robots"]) == ("arrived", [1, 2, 3, 4, 7])
    assert report["trajectory_sha256"] == LocalFleet(GUESTED).execute()["trajectory_sha256"]
    assert fleet.robots[7].node is process
    assert isinstance(process, RobotNode)
    assert process.verdict == "arrived"


@pytest.mark.slow
def test_no_trajectory_shows_who_asks_between_two_ticks_while_nobody_takes_part() -> None:
    """What the scenario does as a tick opens comes before anybody is admitted: here it pauses a guest at
    once. The others were fenced, and come back while it is paused."""
    times = (*((robot, 1.0, 2.3) for robot in SWAP.ids), (7, 2.05, 2.55))
    faults = [ProcessFault(robot, at, "pause") for robot, at, _ in times]
    faults += [ProcessFault(robot, until, "resume") for robot, _, until in times]
    orders, time_ = (Order(2.0, add=GUEST),), replace(SWAP.time, endless=True)
    scenario = replace(SWAP, orders=orders, process=tuple(faults), time=time_)
    found = []
    for early in (False, True):
        with skipped_waits():
            fleet = LocalFleet(scenario)
            core = fleet.world.world.coordinator
            process = fleet.start(7) if early else None
            fleet.network.run(lambda core=core: bool(core.membership.fleet.newcomers))  # type: ignore[misc]
            assert not core.active
            if process is not None:
                process.wake(math.inf)  # asks to join
            fleet.network.run(lambda core=core: core.tick >= 160)  # type: ignore[misc]
        fleet.world.interrupt("interrupted", "")
        assert (41, 7, "pause") in [(tick, fault.robot, fault.event) for tick, fault in core.lives.applied]
        found.append((core.tick, fleet.report["trajectory_sha256"]))
    assert found[0] == found[1]


def test_a_process_that_waits_for_an_order_that_never_comes_is_told_so() -> None:
    fleet = LocalFleet(replace(GUESTED, time=replace(SWAP.time, limit=0.15)))
    process = fleet.start(7)
    process.wake(math.inf)
    report = fleet.execute()
    assert (report["verdict"], report["faults"]["given_up"]) == ("timeout", [])
    assert isinstance(process, RobotNode)
    process.wake(math.inf)
    assert process.verdict == "timeout"


def test_a_guest_that_appears_as_the_run_ends_is_told_that_it_is_over() -> None:
    """A robot that was removed while it was paused keeps the world waiting for what it reports."""
    orders = (Order(0.0, add=GUEST), Order(0.0, remove=2))
    pause = (ProcessFault(2, 0.0, "pause"),)
    for limit in range(1, 6):
        time_ = replace(SWAP.time, limit=limit * SWAP.time.step)
        with skipped_waits():
            fleet = LocalFleet(replace(SWAP, time=time_, orders=orders, process=pause))
            assert fleet.execute()["verdict"] == "timeout"


def test_a_process_that_has_died_before_its_order_keeps_nobody_waiting() -> None:
    clock = Stopwatch()
    admissions = Admissions("r", WorldCore(GUESTED), True, clock)
    reply = admissions.refusal(Join(7, "dies", None))
    assert isinstance(reply, Wait)
    assert not admissions.missing()
    assert 7 not in admissions.absent()
    assert admissions.is_asked_soon()
    clock.now = reply.after * 10
    assert not admissions.is_asked_soon()
    admissions.refusal(Join(7, "lives", None))
    admissions.expect(7)
    assert admissions.is_asked_soon()
    assert admissions.refusal(Join(7, "lives", None)) is None  # its disk is there
    assert not admissions.is_asked_soon()
