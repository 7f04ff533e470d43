"""The shrinker: what is not needed goes, what is needed stays."""

from __future__ import annotations

from dataclasses import replace

import pytest

from deploy.studies.falsify.scenarios.draw import drawn
from deploy.studies.falsify.shrinking.shrink import shrunk
from protocol.scenario.file import validated
from protocol.scenario.model import Control, Link, Scenario, Sensing, Time, Workspace

ENOUGH = 5000


@pytest.fixture(scope="module")
def large() -> Scenario:
    return max((drawn(0, number)[0] for number in range(200)), key=lambda s: len(s.process) * len(s.robots))


def test_of_what_does_not_matter_nothing_is_left(large: Scenario) -> None:
    smallest, tried = shrunk(large, lambda _: True, ENOUGH)
    (robot,) = smallest.robots
    assert (robot.id, robot.start, robot.goal) == (1, (0.0, 0.0), (0.0, 0.0))
    assert smallest.ticks(smallest.time.limit) == 1
    assert smallest.process == ()
    assert (smallest.link, smallest.sensing, smallest.seed) == (Link(), (Sensing(),), 0)
    assert smallest.control == Control()
    assert replace(smallest.time, limit=60.0) == Time()
    assert tried < 200


def test_what_matters_stays(large: Scenario) -> None:
    """A robot restarted twice, while another one is late by more than 3 ticks, for at least 20 ticks."""
    robot = large.process[0].robot

    def shows(scenario: Scenario) -> bool:
        events = [fault for fault in scenario.process if fault.robot == robot]
        return len(events) >= 1 and len(scenario.robots) >= 2 and scenario.ticks(scenario.time.limit) >= 20

    def renamed(scenario: Scenario) -> bool:
        return len(scenario.process) >= 1 and len(scenario.robots) >= 2 and scenario.time.limit > 0.5

    smallest, _ = shrunk(large, renamed, ENOUGH)
    assert len(smallest.process) == 1
    assert smallest.ids == (1, 2)
    assert 0.5 < smallest.time.limit <= 0.6
    kept, _ = shrunk(large, shows, ENOUGH)
    assert [fault.robot for fault in kept.process] == [robot]
    assert len(kept.robots) == 2
    assert kept.ticks(kept.time.limit) == 20


@pytest.mark.parametrize("budget", [0, 1, 7])
def test_the_budget_is_kept_and_what_was_reached_is_valid(large: Scenario, budget: int) -> None:
    tries = 0

    def shows(_: Scenario) -> bool:
        nonlocal tries
        tries += 1
        return True

    smaller, tried = shrunk(large, shows, budget)
    assert tries == tried <= budget
    assert validated(smaller) == smaller


def test_numbers_become_round_as_far_as_they_may(large: Scenario) -> None:
    bound = large.workspace.shape.around.radius * 1.23456789
    scenario = replace(large, workspace=Workspace(bound))
    smallest, _ = shrunk(scenario, lambda s: (s.workspace.radius or 0.0) > 0.9 * bound, ENOUGH)
    assert len(repr(smallest.workspace.radius)) <= 5
