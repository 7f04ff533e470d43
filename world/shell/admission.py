"""Admission: assigns one process to each robot.

Requests to join are idempotent: a process that repeats one is admitted as the same life, until it reports
that this life is over. If an admitted process does not show its liveliness token in time, its life ends, and
another process may join. Of two processes with one id the second is refused, and so is one that was given up
repeatedly. The process of a robot that is still to be added waits.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import inf

from protocol import joining
from protocol.errors import JoinError
from protocol.messages import Health
from world.coordinator.records import Fate
from world.shell.checkpoint import Checkpoint, Processes
from world.world import WorldCore

GRACE = 60.0  # s for which robots wait for the restart of a world with a checkpoint
RESERVATION = 2.0  # s between admission and liveliness token
CHANCES = 2  # times that a live process may be given up before its robot stays down
_RETRY = 0.2  # s between requests, while another process joins under the same id, or the disk is not present
_SOON = 5 * _RETRY  # s within which a process that waits for its disk asks again, if it is alive


@dataclass
class Slot:
    """One robot id, and its admitted process."""

    session: str = ""
    since: float = 0.0  # s, time of its admission
    missing: float = inf  # s, time since which its token is missing, though it may be alive
    health: Health | None = None  # report of its process at the end of the run
    notified: bool = False  # informed of the end of the run
    blamed: Counter[str] = field(default_factory=Counter)  # times that each process was given up


class Admissions:
    """All slots of a fleet, and their processes: only ids with a life in the run have a slot.

    Args:
        epochs: of the coordinators of this run, this world's last.
        clock: time, s.
        checkpoint: of the world, if it keeps one: then robots wait for another world.
        processes: admitted by an earlier world; a robot's newest keeps its slot while it is present.
    """

    def __init__(
        self,
        run: str,
        world: WorldCore,
        lockstep: bool,
        clock: Callable[[], float] = time.monotonic,
        epochs: Sequence[int] = (0,),
        checkpoint: Checkpoint | None = None,
        processes: Processes | None = None,
    ) -> None:
        self._world = world
        self.processes = Processes() if processes is None else processes  # all that were admitted
        newest, lives = self.processes.newest, world.lives.of
        self.slots = {robot: Slot(newest.get(robot, "")) for robot in lives}  # by robot id
        self._tokens: set[tuple[int, str]] = set()  # robots and sessions of present processes
        # Newest request of each robot that waits for its disk, s, by the clock; -inf afterwards.
        self._early: dict[int, float] = {}
        self._name, self._lockstep, self._clock = run, lockstep, clock
        self._epoch, self._epochs, self._checkpoint = epochs[-1], {0, *epochs}, checkpoint

    def expect(self, robot: int) -> None:
        """Add a slot for an added robot whose disk is present."""
        self.slots.setdefault(robot, Slot())

    # -- requests

    def refusal(self, join: joining.Join) -> joining.JoinReply | None:
        """The reply to a process that cannot take part, or not yet; None if it can."""
        robot = join.robot
        if join.epoch not in self._epochs:
            return joining.OtherRun()
        self.dismiss(robot)
        lives = self._world.lives
        status = lives.roster.status(robot)
        if status in ("standing", "live"):
            self.expect(robot)  # also if its disk has appeared at the end of the run, after the last tick
        slot = self.slots.get(robot)
        if self._fate(join) == "removed":
            return joining.Finished("removed")
        if status == "appearing":
            return self._wait(robot, f"the disk of robot {robot} has not appeared yet")
        if slot is None or status == "gone":
            return self._unlisted(join)
        taken = self.is_present(robot) and not self.processes.fate(robot, slot.session, lives.of)
        if taken and slot.session != join.session:
            return joining.Refusal(
                f"robot {robot} is already running in run {self._name!r}; use another id or run"
            )
        return None

    def is_newest(self, join: joining.Join) -> bool:
        """Whether this process is the newest admitted for its robot."""
        return self.processes.newest.get(join.robot) == join.session

    def may_come(self, join: joining.Join) -> bool:
        """Whether this process may have a life, now or later."""
        return not self._fate(join) and self.slots[join.robot].blamed[join.session] < CHANCES

    def _fate(self, join: joining.Join) -> Fate:
        return self.processes.fate(join.robot, join.session, self._world.lives.of)

    def _unlisted(self, join: joining.Join) -> joining.JoinReply:
        """The reply to the process of a robot that is not, or no longer, in the run."""
        robot = join.robot
        if self._world.schedule.adds(robot) and not self._fate(join):
            return self._wait(robot, f"robot {robot} has not been added yet")
        gone = self._world.lives.roster.status(robot) == "gone"
        if gone or robot in self._early:
            return joining.Finished("removed")
        name = self._world.scenario.name
        return joining.Refusal(f"robot {robot} is not in scenario {name!r} of run {self._name!r}")

    def _wait(self, robot: int, reason: str) -> joining.JoinReply:
        self._early[robot] = self._clock()
        return joining.Wait(_RETRY, reason)

    def enlist(self, join: joining.Join) -> joining.JoinReply:
        """Admit a process that is not refused as a new life of its robot; again as the same life if it has
        not begun that, since the reply was lost.
        """
        robot, world, slot = join.robot, self._world, self.slots[join.robot]
        if slot.blamed[join.session] >= CHANCES:
            return joining.Refusal(f"robot {robot}: this process was given up {CHANCES} times; start another")
        if reason := self._obstacle(join):
            return joining.Wait(_RETRY, reason)
        life, newest = world.lives.of[robot], self.processes.newest.get(robot)
        before = life.fate
        if life.goes_on and join.session == newest:
            if join.health is None or join.health.incarnation < life.incarnation:
                slot.session = join.session  # it lost its slot while the scenario paused it
                return self._admission(robot)
            world.lost(robot)  # as the process reports
        elif life.goes_on:
            world.lost(robot, "showed no sign of life after it was admitted; another process came")
        try:
            world.join(robot)
        except JoinError as error:
            return joining.Refusal(str(error))
        slot.session, slot.since = join.session, self._clock()
        self.processes.admit(robot, join.session, before)
        return self._admission(robot)

    def _obstacle(self, join: joining.Join) -> str:
        """The reason why a process must wait; "" if it need not."""
        robot, slot = join.robot, self.slots[join.robot]
        life = self._world.lives.of[robot]
        if self._fate(join):
            return f"the scenario has ended this process of robot {robot}"
        if life.paused:
            return f"robot {robot} is paused by the scenario"
        other = slot.session not in ("", join.session) and not self.is_present(robot)
        reserved = other and self._clock() < slot.since + RESERVATION
        return f"another process is joining as robot {robot}" if reserved else ""

    def overview(self) -> joining.Overview:
        """For monitors."""
        goals = tuple(status for status in self._world.goal_statuses() if status.number)
        return joining.Overview(self._world.scenario, self._lockstep, goals)

    def _admission(self, robot: int) -> joining.Admission:
        grace = GRACE if self._checkpoint is not None and self._checkpoint.kept else 0.0
        lives = self._world.lives
        life, scenario = lives.of[robot].incarnation, self._world.scenario
        return joining.Admission(life, self._lockstep, scenario, grace, lives.founded, self._epoch)

    # -- presence

    def is_present(self, robot: int) -> bool:
        """Whether the token of the robot's admitted process is present."""
        return (robot, self.slots[robot].session) in self._tokens

    def _may_be_there(self, robot: int) -> bool:
        return self.is_present(robot) or self.slots[robot].missing < inf

    def arrive(self, robot: int, session: str) -> bool:
        """A token appeared; returns whether it is the admitted process's."""
        self._tokens.add((robot, session))
        slot = self.slots.get(robot)
        if slot is None or slot.session != session:
            return False
        slot.missing = inf
        return True

    def go(self, robot: int, session: str) -> bool:
        """A token disappeared: its process ended, hangs, or is disconnected. True for the admitted one."""
        self._tokens.discard((robot, session))
        slot = self.slots.get(robot)
        return slot is not None and slot.session == session

    def miss(self, robot: int) -> None:
        """Note that the token of the robot's process, which may be alive, is missing."""
        slot = self.slots[robot]
        slot.missing = min(slot.missing, self._clock())

    def leave(self, robot: int) -> None:
        """Note that the robot's process is gone."""
        slot = self.slots[robot]
        slot.session, slot.missing = "", inf

    def missing(self, at_least: float = 0.0) -> list[int]:
        """Robots whose token has been missing for this time, s, and whose process may be alive."""
        since = self._clock() - at_least
        return [robot for robot, slot in self.slots.items() if slot.missing <= since]

    def absent(self) -> frozenset[int]:
        """Robots without an admitted process with a present token."""
        return frozenset(robot for robot in self.slots if not self.is_present(robot))

    # -- the end

    def owing_health(self) -> list[int]:
        """Robots that can, but did not, report at the end of the run."""
        return [n for n, slot in self.slots.items() if slot.health is None and self._may_be_there(n)]

    def unnotified(self) -> list[int]:
        """Robots that can be, but are not, informed of the end of the run."""
        return [n for n, slot in self.slots.items() if not slot.notified and self._may_be_there(n)]

    def is_asked_soon(self) -> bool:
        """Whether a process that waits for its disk will soon ask again, and learn that the run is over."""
        return any(asked > self._clock() - _SOON for asked in self._early.values())

    def dismiss(self, robot: int) -> None:
        """A process no longer waits for its disk."""
        if robot in self._early:
            self._early[robot] = -inf
