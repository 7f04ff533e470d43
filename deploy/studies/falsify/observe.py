"""One run within this process, watched: its report, and where everybody was."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import Any

from deploy.local import LocalFleet
from deploy.studies.falsify.skipped_waits import skipped_waits
from deploy.studies.falsify.violation import Violation, raised, violations
from protocol.codec import decode
from protocol.events import Event, Sample
from protocol.keys import world_key
from protocol.messages import Clock, Truth
from protocol.scenario import Scenario

PATIENCE = 120.0  # s that a run may take, skipped waits included; the world itself gives up sooner
_CUT = "interrupted"  # verdict of a run that is not waited for
_GRACE = 0.01  # s after the verdict for those to report who can


@dataclass(frozen=True)
class Observation:
    """What came of a run; no report if an exception ended it."""

    report: dict[str, Any] | None
    truths: list[Truth]
    violations: list[Violation]

    @property
    def trajectory(self) -> str:
        """Digest of the trajectory, empty if there is none."""
        return "" if self.report is None else str(self.report["trajectory_sha256"])


class Watch:
    """A node that hears the truth, and says when the run has gone on for long enough.

    A world waits some seconds for the last reports of robots that the scenario has stopped; nobody
    needs them here.
    """

    def __init__(self) -> None:
        self.finished = False
        self.truths: list[Truth] = []
        self.deadline = inf
        self._judged = False

    def begin(self) -> None:
        """The run begins now."""
        self.deadline = time.monotonic() + PATIENCE

    def handle(self, event: Event) -> None:
        if not isinstance(event, Sample):
            return
        message = decode(event.key, event.payload)
        if isinstance(message, Truth):
            self.truths.append(message)
        elif isinstance(message, Clock) and message.verdict and not self._judged:
            self._judged, self.deadline = True, time.monotonic() + _GRACE

    def wake(self, now: float) -> None:  # noqa: ARG002
        self.deadline = inf
        self.finished = True

    def enough(self) -> bool:
        return self.finished or time.monotonic() > self.deadline


def observe(scenario: Scenario, joining: Sequence[int] | None = None) -> Observation:
    """Run a scenario (k a number); `joining` is the order in which robots join, of their ids unless given."""
    watch = Watch()
    with skipped_waits():
        try:
            report = _run(scenario, joining, watch)
        except Exception as error:  # noqa: BLE001  whatever it is, it is what is looked for
            return Observation(None, watch.truths, [raised(error)])
    found = violations(report)
    if report["verdict"] == _CUT:
        found.append(Violation("endless", report["reason"]))
    return Observation(report, watch.truths, found)


def _run(scenario: Scenario, joining: Sequence[int] | None, watch: Watch) -> dict[str, Any]:
    watch.begin()
    fleet = LocalFleet([scenario], joining=joining)
    bus = fleet.network.connect()
    bus.subscribe(world_key(fleet.run, "truth"), world_key(fleet.run, "clock"))
    bus.node = watch
    fleet.network.run(lambda: fleet.world.finished or watch.enough())
    fleet.world.interrupt(_CUT, f"has not ended within {PATIENCE:g} s")
    bus.drain()
    (report,) = fleet.world.reports
    return report
