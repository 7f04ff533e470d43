"""Where robots join: who is admitted, who has to wait, who is refused."""

from __future__ import annotations

import time

from protocol import joining
from protocol.errors import JoinError
from world.journal import Journal, Seated
from world.roster import Roster, Seat
from world.turn import Turn

AWAY = 60.0  # s that robots wait for a world that keeps a journal: to be started again, and to replay it
_RETRY = 0.2  # s, while another process is joining under the same id


class Reception:
    """Answers the requests of robots, and keeps their seats; with a journal it tells them how long to wait
    for a world that is gone."""

    def __init__(self, run: str, roster: Roster, lockstep: bool, journal: Journal | None = None) -> None:
        self._run, self._roster, self._lockstep = run, roster, lockstep
        self._journal = journal

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
        """Admit a process to the present run as a new life of its robot, or again as what it is already."""
        robot, world = join.robot, turn.world
        again = robot in world.up and self._roster.seats[robot].session == join.session
        if not self._roster.reserve(robot, join.session, time.monotonic()):
            return joining.Wait(_RETRY, f"another process is joining as robot {robot}")
        if again:  # the reply to its request was lost, or whoever gave it died
            return self._admission(robot, turn)
        if self._journal is not None:
            self._journal.note(Seated(robot, join.session))
        try:
            world.join(robot)
        except JoinError as error:
            return joining.Refusal(str(error))
        return self._admission(robot, turn)

    def _admission(self, robot: int, turn: Turn) -> joining.Admission:
        away = AWAY if self._journal is not None and self._journal.kept else 0.0
        life = turn.world.incarnations[robot]
        return joining.Admission(life, self._lockstep, turn.scenario, turn.oldest, away)

    def overview(self, turn: Turn) -> joining.Overview:
        """For those who only watch."""
        return joining.Overview(turn.scenario, self._lockstep)
