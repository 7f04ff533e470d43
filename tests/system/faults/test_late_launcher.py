"""A launcher that hears of the world's Clock late, or not of each: runs are as ever."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import pytest

from deploy.library.load import load
from deploy.run.fleet import Fleet
from deploy.run.local import LocalFleet
from deploy.run.options import RunOptions
from protocol.messages import Clock
from protocol.scenario.model import Order, ProcessFault, RobotSpec

LOST: Final = 4


class _DeafLocalFleet(LocalFleet):
    """Its launcher hears nothing of one tick."""

    def _follow(self, clock: Clock) -> None:
        if clock.tick != LOST:
            super()._follow(clock)


class _DeafFleet(Fleet):
    """The same, of real processes."""

    def _follow(self, clock: Clock) -> None:
        if clock.tick != LOST:
            super()._follow(clock)


@pytest.mark.slow
def test_who_is_added_again_comes_though_the_end_of_the_one_before_was_not_heard_of() -> None:
    """The robot has a fault in tick 4, is removed in tick 6 and added again in tick 8."""
    newcomer = RobotSpec(3, 0.05, (0.3, 0.3), (0.25, 0.3))
    quick = load("swap-2", ["time.limit=1.0", "time.fence=0.1", "workspace.radius=0.6"])
    step = quick.time.step
    orders = (Order(0.0, add=newcomer), Order(6 * step, remove=3), Order(8 * step, add=newcomer))
    scenario = replace(quick, orders=orders, process=(ProcessFault(3, LOST * step, "kill"),))
    prompt = LocalFleet(scenario).execute()
    assert prompt["faults"]["given_up"] == []
    deaf = _DeafLocalFleet(scenario).execute()
    with _DeafFleet(scenario, RunOptions("mesh")) as fleet:
        real = fleet.execute()
    assert deaf["trajectory_sha256"] == real["trajectory_sha256"] == prompt["trajectory_sha256"]
