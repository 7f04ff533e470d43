"""Robots that hear only those near them: no contact, and all arrive."""

from dataclasses import replace
from typing import Any

import pytest

from deploy.library.load import load
from deploy.run.local import LocalFleet
from protocol.scenario.model import ProcessFault, Scenario
from protocol.scenario.network import Link, Network
from tests.drawn_order import ReorderedFleet

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
@pytest.mark.parametrize("fenced", [False, True])
def test_a_robot_that_begins_anew_among_far_peers_moves_again(fenced: bool) -> None:
    """It gets a line with every peer, although it receives hardly any States."""
    faults = [ProcessFault(robot, 3.0 if fenced else 1.0, "restart") for robot in (3, 9)]
    if fenced:
        faults += [ProcessFault(robot, 1.0, "kill") for robot in (3, 9)]
    report = in_process(crowd(Network("near", 0.06), process=tuple(faults)))
    assert report["verdict"] == "arrived"
    assert report["collisions"] == 0
    assert report["min_clearance"] > -1e-12  # rounding
