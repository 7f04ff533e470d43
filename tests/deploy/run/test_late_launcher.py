"""A launcher that gets to the faults of one run when the next could begin: both runs are as ever."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from deploy.library.load import load
from deploy.run import local
from protocol.bus.events import Event, Sample
from protocol.messages import Clock
from protocol.scenario.model import ProcessFault
from protocol.wire.codec import decode


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
