"""Which process faults are due, as the clock of a run goes by."""

from __future__ import annotations

from collections.abc import Sequence

from protocol.messages import Clock
from protocol.scenario import ProcessFault, Scenario


class FaultSchedule:
    """Process faults of one or more runs that follow each other on the same processes."""

    def __init__(self, scenarios: Sequence[Scenario]) -> None:
        self._scenarios = iter(scenarios)
        self._ended = True
        self._due: list[tuple[int, int, ProcessFault]] = []

    def due(self, clock: Clock) -> list[ProcessFault]:
        """Faults to carry out now, in the order of their ticks; each is returned once."""
        if clock.verdict:
            self._ended = True
            return []
        if self._ended:
            self._ended = False
            self._load(next(self._scenarios, None))
        faults = []
        while self._due and self._due[0][0] <= clock.tick:
            faults.append(self._due.pop(0)[-1])
        return faults

    def _load(self, scenario: Scenario | None) -> None:
        if scenario is not None:
            self._due = sorted(
                (scenario.ticks(fault.at), n, fault) for n, fault in enumerate(scenario.process)
            )
