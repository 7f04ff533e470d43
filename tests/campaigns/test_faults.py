"""Random fault runs: their scenarios, and what a run comes to."""

from __future__ import annotations

import pytest

from tests.campaigns.campaign import Dice
from tests.campaigns.faults import barred, fault_scenario, run

pytestmark = pytest.mark.slow


def test_a_goal_on_which_a_dead_robot_lies_is_barred() -> None:
    scenario = fault_scenario(1)
    one, other = scenario.robots[:2]
    report = {"down": [other.id], "positions": {str(other.id): one.goal}}
    assert barred(scenario, report, {one.id})
    assert not barred(scenario, {"down": [], "positions": {}}, {one.id})


def test_a_run_holds_what_is_promised() -> None:
    outcomes = [run(Dice(seed)) for seed in range(2)]
    assert not any(outcome.violation for outcome in outcomes)
    assert all(outcome.figures["clearance, m"] > 0.0 for outcome in outcomes)
