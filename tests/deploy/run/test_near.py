"""Robots that hear only those near them: no contact, and all arrive."""

from dataclasses import replace
from typing import Any

import pytest

from deploy.library.load import load
from deploy.run.local import LocalFleet
from protocol.scenario.model import ProcessFault, Scenario
from protocol.scenario.network import Network


def crowd(interest: Network, **settings: Any) -> Scenario:
    return replace(load("random-14"), network=interest, **settings)


@pytest.mark.slow
def test_near_robots_arrive_on_ways_as_short_as_if_all_heard_all() -> None:
    near, all_ = (LocalFleet(crowd(Network(interest))).execute() for interest in ("near", "all"))
    assert near["verdict"] == all_["verdict"] == "arrived"
    assert near["nrl"] < 1.05 * all_["nrl"]


@pytest.mark.slow
@pytest.mark.parametrize("fenced", [False, True])
def test_a_robot_that_begins_anew_among_far_peers_moves_again(fenced: bool) -> None:
    """It gets a line with every peer, although it receives hardly any States."""
    faults = [ProcessFault(robot, 3.0 if fenced else 1.0, "restart") for robot in (3, 9)]
    if fenced:
        faults += [ProcessFault(robot, 1.0, "kill") for robot in (3, 9)]
    report = LocalFleet(crowd(Network("near", 0.06), process=tuple(faults))).execute()
    assert report["verdict"] == "arrived"
    assert report["collisions"] == 0
    assert report["min_clearance"] > -1e-12  # rounding
