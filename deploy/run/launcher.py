"""What a launcher does with processes of robots as a run goes on: decided here, done by `RobotProcesses`."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any, Protocol

from protocol.messages import Clock
from protocol.scenario.model import Event, ProcessFault, Scenario


class RobotProcesses(Protocol):
    """The processes of robots, or the nodes in their place."""

    def knows(self, robot: int) -> bool:
        """Whether a robot has, or had, a process."""

    def runs(self, robot: int) -> bool:
        """Whether its process has not ended, as far as is known."""

    def act(self, robot: int, event: Event) -> None:
        """Kill it, pause it, let it go on if it is paused, or end it and start the next one."""

    def welcome(self, robot: int) -> bool:
        """Start a process for a robot that was added; False if one that is frozen has to end before."""


class Launcher:
    """Process faults and newcomers of a run.

    Args:
        scenario: of the run.
        processes: what carries it out.
        turn: of several robots at once, which comes first; the least.
    """

    def __init__(
        self, scenario: Scenario, processes: RobotProcesses, turn: Callable[[int], Any] = int
    ) -> None:
        self._processes, self._turn = processes, turn
        faults = sorted(scenario.process, key=lambda fault: fault.at)  # stable: as written, if at once
        self._due = deque((scenario.ticks(fault.at), fault) for fault in faults)
        self._paused: set[int] = set()
        self._started: set[int] = set()  # newcomers whose processes were started

    def follow(self, clock: Clock) -> None:
        """Do what is due."""
        for fault in sorted(self.due(clock), key=lambda fault: self._turn(fault.robot)):
            self.carry_out(fault)
        for robot in sorted(clock.newcomers, key=self._turn):
            self._welcome(robot)
        self._started &= set(clock.newcomers)

    def carry_out(self, fault: ProcessFault) -> None:
        """Carry out one fault on a process; nothing to one that has not come yet."""
        robot, processes = fault.robot, self._processes
        if not processes.knows(robot):
            return
        if fault.event in ("kill", "pause"):
            self._started.discard(robot)  # a robot that is added under its id has a process of its own
        (self._paused.add if fault.event == "pause" else self._paused.discard)(robot)
        processes.act(robot, fault.event)

    def removed(self, robot: int) -> None:
        """The process of a robot that was removed has ended."""
        self._started.discard(robot)

    def _welcome(self, robot: int) -> None:
        """Start a process for a robot that was added, once that of an earlier one with its id has left."""
        leaves = not self._processes.runs(robot) or robot in self._paused
        if robot not in self._started and leaves and self._processes.welcome(robot):
            self._started.add(robot)
            self._paused.discard(robot)

    def due(self, clock: Clock) -> list[ProcessFault]:
        """Faults to carry out now, in the order of their times; each is returned once.

        None before the run has begun: all robots begin it, whatever happens to them in the first tick.
        Nothing happens to a process whose robot is not there, in the world as here: the process of the next
        one may have come before this is due. A clock that is lost is made up for by any later one, the last
        included.
        """
        faults = []
        until = clock.tick - 1 if clock.verdict else clock.tick  # the last tick that was open
        while clock.founded and self._due and self._due[0][0] <= until:
            tick, fault = self._due.popleft()
            if (tick, fault.robot) not in clock.passed_over:
                faults.append(fault)
        return faults
