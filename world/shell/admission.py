"""Admission: which process stands for which robot, as the world sees it.

A process asks to join as often as it likes: asking again is asking once, until it says that the life it
was given is over. One that does not show its liveliness token within a while after it was admitted makes
room for another, and its life is over. Of two processes with one id the second is refused, and so is
one that had to be given up again and again.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from math import inf

from protocol.errors import JoinError
from protocol.messages import Health
from protocol.requests import joining
from world.shell.journal import Journal, Seated
from world.shell.run import Run

AWAY = 60.0  # s that robots wait for a world that keeps a journal: to be started again, and to replay it
RESERVATION = 2.0  # s between admission and liveliness token
CHANCES = 2  # how often a process that lives may be given up: after that its robot stays down
_RETRY = 0.2  # s, while another process is joining under the same id


@dataclass
class Slot:
    """One robot id: the process (session) that was admitted, and whether its token is there."""

    session: str = ""
    present: bool = False
    since: float = 0.0  # s, by the clock: when it was admitted
    missing: float = inf  # s, by the clock: since when the token of a process that may be alive is not there
    granted: int = 0  # incarnation that it was given
    health: Health | None = None  # what its process reported at the end of the run
    notified: bool = False  # it knows that there is nothing more to do
    blamed: Counter[str] = field(default_factory=Counter)  # how often each process was given up
    ended: str = ""  # the process that the scenario of an earlier run has ended, or stopped
    removed: str = ""  # that of a robot which had this id before it was removed

    @property
    def occupied(self) -> bool:
        """Whether there is a process, or may be."""
        return self.present or self.missing < inf


class Admissions:
    """All slots of a fleet, and who is given one: only ids that have a life in the run have a slot.

    Args:
        run: its name.
        ids: of the robots.
        lockstep: what those who are admitted are told.
        clock: tells the time, s.
        journal: where the world notes who was admitted; robots wait for a world that has one to come back.
    """

    def __init__(
        self,
        run: str,
        ids: Iterable[int],
        lockstep: bool,
        clock: Callable[[], float] = time.monotonic,
        journal: Journal | None = None,
    ) -> None:
        self.slots = {robot: Slot() for robot in ids}
        self._former: set[int] = set()  # of earlier runs
        self._name, self._lockstep, self._clock = run, lockstep, clock
        self._journal = journal

    def begin(self, ids: Iterable[int]) -> None:
        """A run of these robots begins; whose process was there in the one before has its slot."""
        self._former.update(self.slots)
        self.slots = {robot: self.slots.get(robot) or Slot() for robot in ids}
        for slot in self.slots.values():
            slot.health = None

    def renew(self, robot: int) -> None:
        """A robot is to be added; one that had its id before is no concern any more."""
        slot = self.slots.get(robot)
        if slot is not None:
            self.slots[robot] = Slot(removed=slot.session or slot.removed)

    def expect(self, robot: int) -> None:
        """The disk of a robot that was added is there; a process may join, but for that of an earlier one
        with its id, which may not know yet that its robot was removed."""
        slot = self.slots.setdefault(robot, Slot())
        slot.removed = slot.session or slot.removed

    # -- who asks

    def refusal(self, join: joining.Join, run: Run) -> joining.Reply | None:
        """Why this process cannot take part, or not yet; None if it can."""
        robot = join.robot
        slot = self.slots.get(robot)
        if slot is None:
            return self._nobody(robot, run)
        if join.session == slot.removed:
            return joining.Finished("removed")
        if slot.present and slot.session not in ("", join.session):
            return joining.Refusal(
                f"robot {robot} is already running in run {self._name!r}; use another id or run"
            )
        return None

    def _nobody(self, robot: int, run: Run) -> joining.Reply:
        """What the process of a robot is told whose disk is not there."""
        status = run.world.coordinator.lives.status_of(robot)
        if status == "appearing":
            return joining.Wait(_RETRY, f"the disk of robot {robot} has not appeared yet")
        if status == "gone" or robot in self._former:
            return joining.Finished("removed")
        name, scenario = self._name, run.scenario.name
        return joining.Refusal(f"robot {robot} is not in scenario {scenario!r} of run {name!r}")

    def enlist(self, join: joining.Join, run: Run) -> joining.Reply:
        """Admit a process that is not refused to the present run as a new life of its robot, or again as
        the life that it was given if it has not lived it yet: the reply was lost."""
        robot, world, slot = join.robot, run.world, self.slots[join.robot]
        if slot.blamed[join.session] >= CHANCES:
            return joining.Refusal(f"robot {robot}: this process was given up {CHANCES} times; start another")
        if reason := self._obstacle(join, run):
            return joining.Wait(_RETRY, reason)
        if slot.session not in ("", join.session):
            world.coordinator.lost(
                robot, "showed no sign of life after it was admitted; another process came"
            )
        elif slot.session and world.coordinator.lives.goes_on(robot, slot.granted):
            if _lived(join) < slot.granted:
                return self._admission(slot, run)
            world.coordinator.lost(robot)  # as the process itself says
        if self._journal is not None:
            self._journal.note(Seated(robot, join.session))
        try:
            slot.granted = world.coordinator.join(robot)
        except JoinError as error:
            return joining.Refusal(str(error))
        slot.session, slot.since = join.session, self._clock()
        return self._admission(slot, run)

    def _obstacle(self, join: joining.Join, run: Run) -> str:
        """Why a process has to wait; "" if it need not."""
        robot, slot = join.robot, self.slots[join.robot]
        life = run.world.coordinator.lives.of[robot]
        if join.session == slot.ended or (join.session == slot.session and life.ended):
            return f"the scenario has ended this process of robot {robot}"
        if life.paused:
            return f"robot {robot} is paused by the scenario"
        taken = slot.session not in ("", join.session) and self._clock() < slot.since + RESERVATION
        return f"another process is joining as robot {robot}" if taken else ""

    def overview(self, run: Run) -> joining.Overview:
        """For those who only watch."""
        statuses = (run.world.goal_status(robot) for robot in run.scenario.ids)
        goals = tuple(status for status in statuses if status is not None and status.number)
        return joining.Overview(run.scenario, self._lockstep, goals)

    def _admission(self, slot: Slot, run: Run) -> joining.Admission:
        away = AWAY if self._journal is not None and self._journal.kept else 0.0
        founded = run.world.coordinator.lives.founded
        return joining.Admission(slot.granted, self._lockstep, run.scenario, run.oldest, away, founded)

    # -- who is there

    def arrive(self, robot: int) -> None:
        """The robot's liveliness token is there."""
        slot = self.slots[robot]
        slot.present, slot.missing = True, inf

    def blame(self, robot: int) -> None:
        """The robot's process was given up although its token is there."""
        slot = self.slots[robot]
        slot.blamed[slot.session] += 1

    def miss(self, robot: int) -> None:
        """The robot's liveliness token is gone: its process ended, hangs, or is cut off."""
        slot = self.slots[robot]
        slot.present, slot.missing = False, min(slot.missing, self._clock())

    def leave(self, robot: int) -> None:
        """The robot's process is taken to be gone."""
        slot = self.slots[robot]
        slot.present, slot.session, slot.missing = False, "", inf

    def end(self, robot: int) -> None:
        """A run that is over has ended the robot's process, or stopped it; its launcher may do so later.
        The next run is for another one."""
        slot = self.slots.get(robot)
        if slot is not None and slot.session:
            slot.ended, slot.session = slot.session, ""

    @property
    def sessions(self) -> dict[int, str]:
        """Which process is each robot that has one, by its own name."""
        return {robot: slot.session for robot, slot in self.slots.items() if slot.session}

    @property
    def ended(self) -> dict[int, str]:
        """By robot, the newest of its processes that a scenario which is over has ended."""
        return {robot: slot.ended for robot, slot in self.slots.items() if slot.ended}

    def bar(self, robot: int, session: str) -> None:
        """An earlier world saw the scenario end this process; it does not come back, even if it lives yet."""
        if robot in self.slots:
            self.slots[robot].ended = session

    def missing(self, at_least: float = 0.0) -> list[int]:
        """Robots whose token is gone for so long, s, and whose process may yet be alive."""
        since = self._clock() - at_least
        return [robot for robot, slot in self.slots.items() if slot.missing <= since]

    def resume(self, robot: int, session: str, granted: int) -> None:
        """An earlier world admitted this process; its token is to be seen again."""
        self.slots[robot].session, self.slots[robot].granted = session, granted
        self.miss(robot)

    def absent(self) -> frozenset[int]:
        """Robots without an admitted process whose token is there."""
        return frozenset(r for r, slot in self.slots.items() if not (slot.present and slot.session))

    # -- the end

    def owing_health(self) -> list[int]:
        """Robots that have not reported at the end of the run, and can."""
        return [robot for robot, slot in self.slots.items() if slot.occupied and slot.health is None]

    def unnotified(self) -> list[int]:
        """Robots that do not know yet that it is over, and can be told."""
        return [robot for robot, slot in self.slots.items() if slot.occupied and not slot.notified]


def _lived(join: joining.Join) -> int:
    """Incarnation of the life that the process has ended, 0 for none."""
    return 0 if join.health is None else join.health.incarnation
