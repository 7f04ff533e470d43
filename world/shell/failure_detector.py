"""Failure detection: gives up robots with failed processes, and decides which robots to wait for.

A process fails when its liveliness token is gone, when it does not join in time, or when it does not answer
an open tick of lock-step in time, which was told again meanwhile. A token that is gone may come back within
a grace period, since all tokens disappear with a router; timeouts are suspended meanwhile. A failed robot is
given up: it stands still, takes no part, and the others are told.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping

from protocol.joining import Join
from protocol.messages import Tick
from world.shell.admission import Admissions
from world.shell.pacing import Pacing
from world.shell.run import JudgedRun, Phase

GATHERING = 20.0  # s that robots have to join
PATIENCE = 5.0  # s that a lock-step tick waits for a command
GRACE = 5.0  # s that a robot's token may be missing in a run whose processes are started again


def returning(gathering: float, restarts: int, *, lockstep: bool) -> float:
    """Time for which a fenced robot may still return, s. Lock-step waits for a restarted robot; real time
    goes on, and must not end meanwhile."""
    return gathering if restarts > 0 and not lockstep else 0.0


class FailureDetector:
    """Handles missing robots of the present run.

    Args:
        run, admissions, pacing: of the world.
        tell: sends each robot its Tick.
        gathering: s that robots have to join.
        patience: s that an open tick of lock-step waits for a command.
        grace: s that a token may be missing before its process is given up, 0 for none.
        restarts: how many next lives of each robot a lock-step run waits for.
        say: takes warnings for the operator.

    Attributes:
        expected: by robot, for how many next lives the world has waited so far.
    """

    def __init__(
        self,
        run: JudgedRun,
        admissions: Admissions,
        pacing: Pacing,
        tell: Callable[[Mapping[int, Tick]], None],
        *,
        gathering: float = GATHERING,
        patience: float = PATIENCE,
        grace: float = 0.0,
        restarts: int = 0,
        say: Callable[[str], None] = lambda _: None,
    ) -> None:
        self.expected = Counter[int]()
        self._run = run
        self._admissions, self._pacing, self._tell, self._say = admissions, pacing, tell, say
        self._gathering, self._patience, self._grace = gathering, patience, grace
        self._restarts = restarts if pacing.lockstep else 0

    # -- tokens

    def arrive(self, robot: int, session: str) -> None:
        """A token appeared. If it was the last missing one, messages sent meanwhile are lost."""
        if not self._admissions.arrive(robot, session):
            return
        if self._run.opened and self._pacing.lockstep and not self._admissions.missing():
            self._pacing.begin_again()
            self._tell(self._run.world.open_tick())

    def miss(self, robot: int, session: str) -> None:
        """A token is gone; with it the process, unless its life goes on and there is a grace."""
        if not self._admissions.go(robot, session):
            return
        granted = self._admissions.slots[robot].granted
        if self._grace and self._run.world.lives.goes_on(robot, granted):
            self._admissions.miss(robot)
        else:
            self._gone(robot)

    def supersede(self, join: Join) -> None:
        """A new process of a robot asks to join: give up the robot's missing process at once."""
        robot = join.robot
        others = join.session != self._admissions.slots[robot].session
        if others and robot in self._admissions.missing() and self._admissions.may_come(join):
            self._gone(robot)

    def look(self, now: float) -> None:
        """Give up each robot that is missing for longer than the grace. If others are missing that may come
        back, no timeout runs, except by the clock of real time: no other robot can go on, either."""
        for robot in self._admissions.missing(self._grace):
            self._gone(robot)
        by_the_clock = self._run.opened and not self._pacing.lockstep
        if self._admissions.missing() and not by_the_clock:
            self._pacing.since = now

    def _gone(self, robot: int) -> None:
        self._admissions.leave(robot)
        self._give_up({robot: "has gone: it ended, or is cut off"})
        self._expect(robot)

    # -- gathering and answers

    def gather(self) -> dict[int, Tick] | None:
        """Open the next tick; returns its Ticks, None while it waits for a robot. Real time waits for none
        once it has begun; a later robot joins then."""
        world = self._run.world
        if not world.lives.founded and self._admissions.absent():
            return None
        ticks = world.open_tick()
        if not self._absent():
            return ticks
        if self._pacing.lockstep or world.tick == 0:
            # a fenced life that the scenario wants back must learn that it has to join again
            awaited = world.lives.awaited
            self._tell({robot: tick for robot, tick in ticks.items() if robot in awaited})
            return None
        for robot in world.lives.awaited:
            world.give_up_waiting(robot)
        return world.open_tick()

    def wait(self, now: float) -> None:
        """A tick has not ended, or not opened: tell it again, and in time give up the robots it waits for."""
        if self._run.opened:
            if now > self._pacing.since + self._patience and self._pacing.has_repeated:
                self._lose_patience()
            elif self._pacing.repeats():
                self._tell(self._run.world.open_tick())
        elif not self._absent():
            self._pacing.since = now  # held back by a viewer, not by a robot
        elif now > self._pacing.since + self._gathering:
            self._give_up_gathering()

    def _absent(self) -> frozenset[int]:
        """Robots that have to be there and are not: not joined, or joined without a token."""
        world, absent = self._run.world, self._admissions.absent()
        return world.lives.awaited | (
            absent & frozenset(world.exchange.active) if world.lives.founded else absent
        )

    def _lose_patience(self) -> None:
        """Give up the robots that block the open tick though their tokens are there; restart the timeout."""
        blamed = self._run.world.exchange.blamed()
        for robot in blamed:
            slot = self._admissions.slots[robot]
            slot.blamed[slot.session] += 1
        self._pacing.begin_again()
        self._give_up(blamed)

    def _give_up_gathering(self) -> None:
        """Give up the absent robots after the timeout; abort a run whose first tick has not begun."""
        world, absent = self._run.world, sorted(self._absent())
        if world.tick == 0:
            names = ", ".join(map(str, absent))
            world.finish("aborted", f"no sign of robot {names} within {self._gathering:g} s")
        reason = f"gave no sign within {self._gathering:g} s"
        for robot in absent:
            if world.give_up_waiting(robot, reason) or world.lost(robot, reason):
                self._tell_person(robot, reason)

    def _give_up(self, robots: Mapping[int, str]) -> None:
        """Exclude these robots, with reasons; send the open tick again to robots awaiting their States."""
        world, running = self._run.world, self._run.phase is Phase.RUNNING
        for robot, reason in robots.items():
            if world.lost(robot, reason if running else "") and running:
                self._tell_person(robot, reason)
        if self._run.opened and self._pacing.lockstep:
            waiting = world.exchange.waiting
            self._tell({r: m for r, m in world.open_tick().items() if r in waiting})

    def _expect(self, robot: int) -> None:
        """Wait for the next life of a robot that is started again."""
        running = self._run.phase is Phase.RUNNING
        if running and self.expected[robot] < self._restarts and self._run.world.lives.expect(robot):
            self.expected[robot] += 1

    def _tell_person(self, robot: int, reason: str) -> None:
        self._say(f"tick {self._run.world.tick}: gives up robot {robot}, which {reason}")
