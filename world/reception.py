"""Where robots join: who is admitted, who has to wait, who is refused."""

from __future__ import annotations

import time

from protocol import joining
from protocol.errors import JoinError
from world.roster import Roster, Seat
from world.turn import Turn

_RETRY = 0.2  # s, while another process is joining under the same id


class Reception:
    """Answers the requests of robots, and keeps their seats."""

    def __init__(self, run: str, roster: Roster, lockstep: bool) -> None:
        self._run, self._roster, self._lockstep = run, roster, lockstep

    def refusal(self, join: joining.Join, turn: Turn) -> joining.Refusal | None:
        """Why this process cannot take part at all; None if it can."""
        robot, run = join.robot, self._run
        if robot not in self._roster.seats:
            return joining.Refusal(f"robot {robot} is not in scenario {turn.scenario.name!r} of run {run!r}")
        if self._roster.occupied_by_another(robot, join.session):
            return joining.Refusal(f"robot {robot} is already running in run {run!r}; use another id or run")
        return None

    def seat(self, join: joining.Join) -> Seat:
        """The seat that a process that is not refused asks for."""
        return self._roster.seats[join.robot]

    def enlist(self, join: joining.Join, turn: Turn) -> joining.Reply:
        """Admit a process to the present run as a new life of its robot."""
        if not self._roster.reserve(join.robot, join.session, time.monotonic()):
            return joining.Wait(_RETRY, f"another process is joining as robot {join.robot}")
        try:
            incarnation = turn.world.join(join.robot)
        except JoinError as error:
            return joining.Refusal(str(error))
        return joining.Admission(incarnation, self._lockstep, turn.scenario, turn.oldest)

    def overview(self, turn: Turn) -> joining.Overview:
        """For those who only watch."""
        return joining.Overview(turn.scenario, self._lockstep)
