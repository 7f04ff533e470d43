"""The launcher during a run: process faults and added robots, carried out by `RobotProcesses`."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any, Protocol

from protocol.messages import Clock
from protocol.scenario.model import FaultKind, ProcessFault, Scenario

OnClock = Callable[[Clock], None]


class RobotProcesses(Protocol):
    """The processes of robots, or their nodes in a local fleet."""

    def knows(self, robot: int) -> bool:
        """Whether a robot has, or had, a process."""

    def runs(self, robot: int) -> bool:
        """Whether its process has not ended, as far as is known."""

    def act(self, robot: int, event: FaultKind) -> None:
        """Kill, pause, resume or restart its process."""

    def welcome(self, robot: int) -> bool:
        """Start a process for an added robot; False if a paused process of that id has to end first."""


class Launcher:
    """Process faults and newcomers of a run.

    `turn` is a sort key that orders actions on several robots at once.
    """

    def __init__(
        self, scenario: Scenario, processes: RobotProcesses, turn: Callable[[int], Any] = int
    ) -> None:
        self._processes, self._turn = processes, turn
        faults = sorted(scenario.process, key=lambda fault: fault.at)  # stable for equal times
        self._due = deque((scenario.ticks(fault.at), fault) for fault in faults)
        self._paused: set[int] = set()
        self._started: set[int] = set()  # newcomers whose processes were started

    def follow(self, clock: Clock) -> None:
        """Do what is due at this Clock."""
        for fault in sorted(self.due(clock), key=lambda fault: self._turn(fault.robot)):
            self.carry_out(fault)
        for robot in sorted(clock.newcomers, key=self._turn):
            self._welcome(robot)
        self._started &= set(clock.newcomers)

    def carry_out(self, fault: ProcessFault) -> None:
        """Carry out one fault; ignored if the robot has no process yet."""
        robot, processes = fault.robot, self._processes
        if not processes.knows(robot):
            return
        if fault.event in ("kill", "pause"):
            self._started.discard(robot)  # a robot added later under this id needs a new process
        (self._paused.add if fault.event == "pause" else self._paused.discard)(robot)
        processes.act(robot, fault.event)

    def removed(self, robot: int) -> None:
        """Note that the process of a removed robot has ended."""
        self._started.discard(robot)

    def _welcome(self, robot: int) -> None:
        """Start a process for an added robot once an earlier one of its id has ended."""
        leaves = not self._processes.runs(robot) or robot in self._paused
        if robot not in self._started and leaves and self._processes.welcome(robot):
            self._started.add(robot)
            self._paused.discard(robot)

    def due(self, clock: Clock) -> list[ProcessFault]:
        """Faults to carry out now, in the order of their times; each is returned once.

        None before the first tick is open, so all robots take part in it. A fault of a robot that is absent
        is skipped, by the world and here alike: it must not hit the process of a later robot of that id. Lost
        Clocks are made up for by later ones.
        """
        faults = []
        until = clock.tick - 1 if clock.verdict else clock.tick  # last open tick
        while clock.founded and self._due and self._due[0][0] <= until:
            tick, fault = self._due.popleft()
            if (tick, fault.robot) not in clock.passed_over:
                faults.append(fault)
        return faults
