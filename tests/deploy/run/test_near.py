"""Robots that hear only those near them: no contact, all arrive, and one trajectory on every bus."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from agents.shell.node import RobotNode
from deploy.library.load import load
from deploy.run.fleet import Fleet
from deploy.run.local import LocalFleet
from deploy.run.options import RunOptions
from protocol.bus.bus import Event, Sample
from protocol.codec import decode
from protocol.messages import Tick
from protocol.scenario.model import Control, ProcessFault, RobotSpec, Scenario, Sensing, Time, Workspace
from protocol.scenario.network import Link, Network
from tests.drawn_order import ReorderedFleet
from tests.skipped_waits import skipped_waits

SHORT = 4.0  # s of simulated time


def crowd(interest: Network, **settings: Any) -> Scenario:
    scenario = load("random-14")
    return replace(scenario, network=interest, **settings)


def in_process(scenario: Scenario, joining: tuple[int, ...] | None = None) -> dict[str, Any]:
    with ReorderedFleet(scenario, joining) if joining else LocalFleet(scenario) as fleet:
        return fleet.execute()


@pytest.mark.slow
def test_near_robots_arrive_on_ways_as_short_as_if_all_heard_all() -> None:
    near, all_ = (in_process(crowd(Network(interest))) for interest in ("near", "all"))
    assert near["verdict"] == all_["verdict"] == "arrived"
    assert near["nrl"] < 1.05 * all_["nrl"]


@pytest.mark.slow
def test_the_order_of_joining_changes_nothing() -> None:
    scenario = crowd(Network("near", 0.1), link=Link(delay=(0.0, 0.2), loss=0.1))
    scenario = replace(scenario, time=replace(scenario.time, limit=SHORT))
    hashes = {in_process(scenario, order)["trajectory_sha256"] for order in (None, scenario.ids[::-1])}
    assert len(hashes) == 1


@pytest.mark.slow
def test_who_of_two_begins_anew_first_changes_nothing() -> None:
    scenario = crowd(Network("near", 0.1))
    scenario = replace(scenario, time=replace(scenario.time, limit=2.0))
    hashes = set()
    for order in ((3, 9), (9, 3)):  # neither is told its near peers before both are there
        faults = tuple(ProcessFault(robot, 1.05, "restart") for robot in order)
        hashes.add(in_process(replace(scenario, process=faults))["trajectory_sha256"])
    assert len(hashes) == 1


@pytest.mark.slow
@pytest.mark.parametrize("fenced", [False, True])
def test_who_begins_anew_among_far_peers_moves_again(fenced: bool) -> None:
    """It gets a line with every peer, although it receives hardly any States."""
    faults = [ProcessFault(robot, 3.0 if fenced else 1.0, "restart") for robot in (3, 9)]
    if fenced:
        faults += [ProcessFault(robot, 1.0, "kill") for robot in (3, 9)]
    report = in_process(crowd(Network("near", 0.06), process=tuple(faults)))
    assert report["verdict"] == "arrived"
    assert report["collisions"] == 0
    assert report["min_clearance"] > -1e-12  # rounding


def test_whoever_is_too_close_for_a_line_is_near() -> None:
    """Both may be farther off than the gap between them is wide: one has to see the other, and make room."""
    robots = (RobotSpec(1, 0.04, (0.0, 0.0), (-0.15, 0.0)), RobotSpec(2, 0.04, (0.09, 0.0), (0.09, 0.0)))
    scenario = Scenario(
        robots,
        time=Time(limit=10.0, tolerance=0.03),
        network=Network("near", 1e-3),
        sensing=(Sensing(noise=5e-4, noise_bound=0.02),),
        process=(ProcessFault(1, 0.1, "restart"),),
        control=Control(k=20.0),
    )
    assert in_process(scenario)["verdict"] == "arrived"


def test_whom_a_summary_has_elsewhere_by_rounding_is_near() -> None:
    """Far from the origin it is off by millimetres, and a line halfway to where it has a peer no use."""
    x, y, room = 9e4 + 0.0069, -9e4, 2.0
    robots = tuple(
        RobotSpec(number, 0.05, (x + ahead, y), (x + 3.0 * ahead, y))
        for number, ahead in ((1, -0.0506), (2, 0.0506))
    )
    corners = ((x - room, y - room), (x + room, y - room), (x + room, y + room), (x - room, y + room))
    scenario = Scenario(
        robots,
        workspace=Workspace(points=corners),
        time=Time(limit=30.0, tolerance=0.01),
        network=Network("near", 1e-3),
        process=tuple(ProcessFault(each.id, 0.05, "restart") for each in robots),
        control=Control(k=20.0, speed=0.02),
    )
    assert in_process(scenario)["verdict"] == "arrived"


@pytest.mark.process
@pytest.mark.timeout(120)
def test_processes_make_the_same_trajectory() -> None:
    scenario = crowd(Network("near", 0.1))
    scenario = replace(scenario, time=replace(scenario.time, limit=SHORT))
    with Fleet(scenario, RunOptions()) as fleet:
        found = fleet.execute()
    assert found["trajectory_sha256"] == in_process(scenario)["trajectory_sha256"]


Hear = Callable[[Event], object]


class Ear:
    """Between a robot's bus and its node: decides when the node hears what."""

    def __init__(self, node: RobotNode, passes: Callable[[RobotNode, Event, Hear], object]) -> None:
        self._node, self._passes = node, passes

    @property
    def finished(self) -> bool:
        return self._node.finished

    @property
    def deadline(self) -> float:
        return self._node.deadline

    def handle(self, event: Event) -> None:
        self._passes(self._node, event, self._node.handle)

    def wake(self, now: float) -> None:
        self._node.wake(now)


def lend_ears(fleet: LocalFleet, passes: Callable[[RobotNode, Event, Hear], object]) -> None:
    for bus in fleet.robots.values():
        assert isinstance(bus.node, RobotNode)
        bus.node = Ear(bus.node, passes)


@pytest.mark.slow
def test_robots_that_lose_each_others_ticks_hear_each_other_where_nobody_waits() -> None:
    lost = []

    def lose(node: RobotNode, event: Event, hear: Hear) -> None:
        """One of the two loses the odd Ticks, the other one the even ones."""
        core = node.core
        if core is not None and isinstance(event, Sample) and event.key.endswith("/tick"):
            message = decode(event.key, event.payload)
            assert isinstance(message, Tick)
            if not message.over and message.tick > 0 and (message.tick + core.robot) % 2:
                lost.append(message)
                return
        hear(event)

    with skipped_waits(), LocalFleet(load("swap-2"), lockstep=False) as fleet:
        lend_ears(fleet, lose)
        assert fleet.execute()["verdict"] == "arrived"
    assert lost
