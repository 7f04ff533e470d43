"""Which process faults are due, as the clock of a run goes by."""

from __future__ import annotations

from collections.abc import Sequence

from protocol.messages import Clock
from protocol.scenario.model import ProcessFault, Scenario


class FaultSchedule:
    """Process faults of one or more runs that follow each other on the same processes.

    Whoever a run leaves killed, paused or removed is restarted for the next one that has it.
    """

    def __init__(self, scenarios: Sequence[Scenario]) -> None:
        self._scenarios = scenarios
        self._run = -1
        self._due: list[tuple[int, ProcessFault]] = []
        self._ended: set[int] = set()  # robots that are killed or removed
        self._paused: set[int] = set()

    def due(self, clock: Clock) -> list[ProcessFault]:
        """Faults to carry out now, in the order of their times; each is returned once.

        None before the run has begun: everybody begins it, whatever happens to them in the first tick.
        None for a run that there is not: the clock is a stranger's. Nothing happens to a process whose robot
        is not there, in the world as here: the process of the next one may have come before this is due.
        A clock that is lost is made up for by any later one of its run, the last included.
        """
        if not self._run <= clock.run_number < len(self._scenarios):
            return []
        begins = clock.run_number > self._run
        if begins:
            self._begin(clock.run_number)
        gathers = not clock.verdict and (begins or (self._run > 0 and not clock.founded))
        faults = self._returns() if gathers else []
        until = clock.tick - 1 if clock.verdict else clock.tick  # the last tick that was open
        while clock.founded and self._due and self._due[0][0] <= until:
            tick, fault = self._due.pop(0)
            if (tick, fault.robot) not in clock.passed_over:
                faults.append(fault)
        for fault in faults:
            self._note(fault)
        return faults

    def _note(self, fault: ProcessFault) -> None:
        """A process that has ended is not there again by being resumed."""
        (self._paused.add if fault.event == "pause" else self._paused.discard)(fault.robot)
        if fault.event in ("kill", "restart"):
            (self._ended.add if fault.event == "kill" else self._ended.discard)(fault.robot)

    def removed(self, robot: int) -> None:
        """The process of a robot that was removed has ended."""
        self._ended.add(robot)

    def added(self, robot: int) -> None:
        """A process was started for a robot that was added."""
        self._ended.discard(robot)
        self._paused.discard(robot)

    def _begin(self, run: int) -> None:
        scenario = self._scenarios[run]
        self._run = run
        faults = sorted(scenario.process, key=lambda fault: fault.at)  # stable: as written, if at once
        self._due = [(scenario.ticks(fault.at), fault) for fault in faults]

    def _returns(self) -> list[ProcessFault]:
        """Whom the present run has, and an earlier one left out: perhaps its process ended only now."""
        ids = self._scenarios[self._run].ids
        return [
            ProcessFault(robot, 0.0, "restart")
            for robot in sorted(self._ended | self._paused)
            if robot in ids
        ]
