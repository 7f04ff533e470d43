"""Real processes that are killed while a fleet runs, and the policy by which robots come back."""

from __future__ import annotations

import signal
from collections.abc import Callable
from typing import Any

import pytest

from deploy.library.load import load
from deploy.run.fleet import Fleet
from deploy.run.options import RunOptions, restarts
from protocol.errors import UsageError
from protocol.messages import Clock
from protocol.scenario.model import Scenario

pytestmark = [pytest.mark.process, pytest.mark.timeout(150)]


def run_fleet(scenario: Scenario, options: RunOptions, act: Callable[[Fleet, Clock], None]) -> dict[str, Any]:
    """The report of one run, and its processes; `act` interferes as the world's clock goes on."""
    fleet: Fleet
    with Fleet(scenario, options, watch=lambda clock: act(fleet, clock)) as fleet:
        return fleet.execute() | {"processes": fleet.processes()}


def kill_twice(killed: list[int]) -> Callable[[Fleet, Clock], None]:
    """Kill robot 2 in two lives, one after the other; their processes are noted in `killed`."""

    def act(fleet: Fleet, message: Clock) -> None:
        life = fleet.pids().get("robot-2")  # both kills must not meet the same one
        if message.tick >= 10 * (len(killed) + 1) and len(killed) < 2 and life and life not in killed:
            killed.append(life)
            fleet.signal("robot-2", signal.SIGKILL)

    return act


def test_a_killed_robot_is_flowed_around_and_the_run_ends() -> None:
    killed = []

    def act(fleet: Fleet, message: Clock) -> None:
        if message.tick >= 10 and not killed:
            killed.append(message.tick)
            fleet.signal("robot-2", signal.SIGKILL)

    slowly = RunOptions(speed=1.0)  # enough to be watched on a busy machine
    report = run_fleet(load("random-4", ["time.fence=0.3"], 3), slowly, act)
    assert killed
    assert report["verdict"] == "aborted"
    assert "robot 2" in report["reason"]
    assert report["collisions"] == 0
    assert report["arrived"] == [1, 3, 4]


def test_by_policy_a_killed_robot_comes_back_and_the_run_succeeds() -> None:
    killed: list[int] = []
    options = RunOptions(restarts=2, speed=1.0)  # slow enough to be watched on a busy machine
    report = run_fleet(load("figure-3b", ["control.speed=0.3"], 2), options, kill_twice(killed))
    assert len(killed) == 2
    assert (report["verdict"], report["collisions"]) == ("arrived", 0)
    restarts = {process["name"]: process["restarts"] for process in report["processes"]}
    assert restarts.pop("robot-2") == 2
    assert set(restarts.values()) == {0}


def test_a_robot_that_fails_more_often_than_the_policy_allows_stays_down() -> None:
    options = RunOptions(restarts=1, speed=2.0)
    report = run_fleet(load("random-4", ["time.fence=0.3"], 3), options, kill_twice([]))
    assert report["verdict"] == "aborted"
    assert report["down"] == [2]


def test_policies() -> None:
    assert [restarts(policy) for policy in ("never", "on-failure", "on-failure:7")] == [0, 3, 7]
    for policy in ("always", "on-failure:", "on-failure:0", "on-failure:-1", "on-failure:x"):
        with pytest.raises(UsageError, match="on-failure:N"):
            restarts(policy)
    with pytest.raises(UsageError, match="--transport local"):
        RunOptions("local", restarts=1)
