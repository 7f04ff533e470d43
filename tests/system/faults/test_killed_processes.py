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


def test_a_robot_that_fails_more_often_than_the_policy_allows_stays_down_and_is_flowed_around() -> None:
    killed: list[int] = []
    options = RunOptions(restarts=1, speed=1.0)  # slow enough to be watched on a busy machine
    report = run_fleet(load("random-4", ["time.fence=0.3"], 3), options, kill_twice(killed))
    assert len(killed) == 2
    assert report["verdict"] == "aborted"
    assert "robot 2" in report["reason"]
    assert (report["collisions"], report["down"], report["arrived"]) == (0, [2], [1, 3, 4])
    restarts = {process["name"]: process["restarts"] for process in report["processes"]}
    assert restarts.pop("robot-2") == 1
    assert set(restarts.values()) == {0}


def test_policies() -> None:
    assert [restarts(policy) for policy in ("never", "on-failure", "on-failure:7")] == [0, 3, 7]
    for policy in ("always", "on-failure:", "on-failure:0", "on-failure:-1", "on-failure:x"):
        with pytest.raises(UsageError, match="on-failure:N"):
            restarts(policy)
    with pytest.raises(UsageError, match="--transport local"):
        RunOptions("local", restarts=1)
