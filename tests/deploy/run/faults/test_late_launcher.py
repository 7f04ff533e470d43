"""A launcher that hears of the world's Clock late, or not of each: runs are as ever."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final, Literal

import pytest

from deploy.library.load import load
from deploy.run import local
from deploy.run.fleet import Fleet
from deploy.run.options import RunOptions
from protocol.bus.bus import Event, Sample
from protocol.codec import decode
from protocol.messages import Clock
from protocol.scenario.model import Order, ProcessFault, RobotSpec

LOST: Final = 4


class _Late(local.FaultInjector):
    """Does nothing until it hears of the second run."""

    def __init__(self, *details: Any) -> None:
        super().__init__(*details)
        self._heard: list[Event] = []

    def handle(self, event: Event) -> None:
        self._heard.append(event)
        message = decode(event.key, event.payload) if isinstance(event, Sample) else None
        if isinstance(message, Clock) and message.run_number == 1:
            heard, self._heard = self._heard, []
            for each in heard:
                super().handle(each)


@pytest.mark.slow
def test_who_is_to_be_killed_or_frozen_takes_no_part_in_the_next_run(monkeypatch: pytest.MonkeyPatch) -> None:
    quick = ["time.fence=0.2", "time.limit=2.0"]
    faults = (ProcessFault(2, 0.3, "kill"), ProcessFault(3, 0.3, "pause"))
    scenarios = [replace(load("figure-3a", quick, 1), process=faults), load("figure-3a", [], 2)]
    prompt = local.LocalFleet(scenarios).execute()
    monkeypatch.setattr(local, "FaultInjector", _Late)
    late = local.LocalFleet(scenarios).execute()
    assert [each["trajectory_sha256"] for each in late] == [each["trajectory_sha256"] for each in prompt]


class _Deaf(local.FaultInjector):
    """Hears nothing of one tick."""

    def handle(self, event: Event) -> None:
        message = decode(event.key, event.payload) if isinstance(event, Sample) else None
        if not (isinstance(message, Clock) and message.tick == LOST):
            super().handle(event)


class _DeafFleet(Fleet):
    """The same, of real processes."""

    def _follow(self, clock: Clock) -> None:
        if clock.tick != LOST:
            super()._follow(clock)


@pytest.mark.slow
@pytest.mark.parametrize("event", ["kill", "pause"])
def test_who_is_added_again_comes_though_the_end_of_the_one_before_was_not_heard_of(
    event: Literal["kill", "pause"], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The robot has a fault in tick 4, is removed in tick 6 and added again in tick 8."""
    newcomer = RobotSpec(3, 0.05, (0.3, 0.3), (0.25, 0.3))
    quick = load("swap-2", ["time.limit=1.0", "time.fence=0.1", "workspace.radius=0.6"])
    step = quick.time.step
    orders = (Order(0.0, add=newcomer), Order(6 * step, remove=3), Order(8 * step, add=newcomer))
    scenario = replace(quick, orders=orders, process=(ProcessFault(3, LOST * step, event),))
    prompt = local.LocalFleet([scenario]).execute()[0]
    assert prompt["faults"]["given_up"] == []
    monkeypatch.setattr(local, "FaultInjector", _Deaf)
    deaf = local.LocalFleet([scenario]).execute()[0]
    with _DeafFleet([scenario], RunOptions("mesh")) as fleet:
        real = fleet.execute()[0]
    assert deaf["trajectory_sha256"] == real["trajectory_sha256"] == prompt["trajectory_sha256"]
