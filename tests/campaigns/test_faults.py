"""Random fault runs: their scenarios, and what a run comes to."""

from __future__ import annotations

import pytest

from protocol.scenario.file import validated
from tests.campaigns.campaign import Dice
from tests.campaigns.faults import barred, fault_scenario, run

pytestmark = pytest.mark.slow


def test_fault_scenarios_are_valid_and_repeatable() -> None:
    for seed in range(60):
        scenario = fault_scenario(seed)
        assert validated(scenario) == scenario == fault_scenario(seed)
        assert 3 <= len(scenario.robots) <= 8
        assert (scenario.link.delay, scenario.link.loss) == ((0.0, 1.0), 0.5)


def test_fault_scenarios_have_every_fault() -> None:
    drawn = [fault_scenario(seed) for seed in range(60)]
    assert {fault.event for s in drawn for fault in s.process} == {"kill", "pause", "resume", "restart"}
    assert {bool(s.link.partition) for s in drawn} == {bool(s.link.duplicate) for s in drawn} == {True, False}
    assert {s.sensing[0].noise > 0.0 for s in drawn} == {True, False}
    assert {len({robot.radius for robot in s.robots}) > 1 for s in drawn} == {True, False}


def test_a_goal_on_which_a_dead_robot_lies_is_barred() -> None:
    scenario = fault_scenario(1)
    one, other = scenario.robots[:2]
    report = {"down": [other.id], "positions": {str(other.id): one.goal}}
    assert barred(scenario, report, {one.id})
    assert not barred(scenario, {"down": [], "positions": {}}, {one.id})


def test_a_run_holds_what_is_promised() -> None:
    outcomes = [run(Dice(seed)) for seed in range(4)]
    assert not any(outcome.violation for outcome in outcomes)
    assert all(outcome.figures["clearance, m"] > 0.0 for outcome in outcomes)
