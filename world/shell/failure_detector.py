"""Failure detection: gives up robots with failed processes, and decides which robots to wait for.

A process fails when its liveliness token disappears, when it does not join in time, or when it does not
answer an open and repeated lock-step tick in time. A missing token may return within a grace period, since
all tokens disappear with a router; timeouts are suspended meanwhile. A failed robot is static from then on,
takes no part, and the others are informed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from protocol.joining import Join
from protocol.messages import Tick
from world.shell.admission import Admissions
from world.shell.pacing import Pacing
from world.shell.run import JudgedRun, Phase

GATHERING = 20.0  # s, time for robots to join
PATIENCE = 5.0  # s, time for a command in lock-step
GRACE = 5.0  # s, time for which a token may be missing in a run with restarts
RETURNS = 1000  # times that a robot is waited for: its link may return, or its process may be started again


def returning(gathering: float, restarts: int, *, lockstep: bool) -> float:
    """Time for which a fenced robot may still return, s. Lock-step waits for a restarted robot; real time
    continues, and must not end meanwhile.
    """
    return gathering if restarts > 0 and not lockstep else 0.0


class FailureDetector:
    """Handles missing robots of the present run.

    Args:
        send: sends each robot its Tick.
        gathering: time for robots to join, s.
        patience: time for a Command in lock-step, s.
        grace: time for which a token may be missing before its process is given up, s; 0 for none.
        restarts: number of next lives of each robot that a lock-step run waits for.
    """

    def __init__(
        self,
        run: JudgedRun,
        admissions: Admissions,
        pacing: Pacing,
        send: Callable[[Mapping[int, Tick]], None],
        *,
        gathering: float = GATHERING,
        patience: float = PATIENCE,
        grace: float = 0.0,
        restarts: int = 0,
        warn: Callable[[str], None] = lambda _: None,
    ) -> None:
        self._run = run
        self._admissions, self._pacing, self._send, self._warn = admissions, pacing, send, warn
        self._gathering, self._patience, self._grace = gathering, patience, grace
        self._restarts = restarts if pacing.lockstep else 0

    # -- tokens

    def arrive(self, robot: int, session: str) -> None:
        """A token appeared. If it was the last missing one, repeat the messages lost meanwhile."""
        if not self._admissions.arrive(robot, session):
            return
        if self._run.opened and self._pacing.lockstep and not self._admissions.missing():
            self._pacing.begin_again()
            self._send(self._run.world.open_tick())

    def miss(self, robot: int, session: str) -> None:
        """A token disappeared: give its process up, unless its life may return within a grace period."""
        if not self._admissions.go(robot, session):
            return
        if self._grace and self._run.world.lives.of[robot].goes_on:
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
        """Give up each robot that is missing for longer than the grace. While others are missing, no timeout
        runs, except in real time, since the present robots cannot continue, either.
        """
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
        """Open the next tick; returns its Ticks, None while a robot is awaited. Real time waits only before
        its first tick; later robots join then.
        """
        world = self._run.world
        if not world.lives.founded and self._admissions.absent():
            return None
        ticks = world.open_tick()
        if not self._absent():
            return ticks
        if self._pacing.lockstep:
            # a fenced life that the scenario resumes must learn that it has to join again
            awaited = world.lives.awaited
            self._send({robot: tick for robot, tick in ticks.items() if robot in awaited})
            return None
        for robot in world.lives.awaited:
            world.give_up_waiting(robot)
        return world.open_tick()

    def wait(self, now: float) -> None:
        """Repeat a tick that has not opened or ended; in time give up the robots that it waits for."""
        if self._run.opened:
            if now > self._pacing.since + self._patience and self._pacing.has_repeated:
                self._lose_patience()
            elif self._pacing.repeats():
                self._send(self._run.world.open_tick())
        elif not self._absent():
            self._pacing.since = now  # paused by a viewer, not by a robot
        elif now > self._pacing.since + self._gathering:
            self._give_up_gathering()

    def _absent(self) -> frozenset[int]:
        """Required robots that have not joined, or joined without a token."""
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
        """Give up the absent robots after the timeout; before the first tick, abort the run."""
        world, absent = self._run.world, sorted(self._absent())
        if world.tick == 0:
            names = ", ".join(map(str, absent))
            world.finish("aborted", f"no sign of robot {names} within {self._gathering:g} s")
        reason = f"gave no sign within {self._gathering:g} s"
        for robot in absent:
            if world.give_up_waiting(robot, reason) or world.lost(robot, reason):
                self._warn_operator(robot, reason)

    def _give_up(self, robots: Mapping[int, str]) -> None:
        """Exclude these robots, with reasons; repeat the open tick to robots that await their States."""
        world, running = self._run.world, self._run.phase is Phase.RUNNING
        for robot, reason in robots.items():
            if world.lost(robot, reason if running else "") and running:
                self._warn_operator(robot, reason)
        if self._run.opened and self._pacing.lockstep:
            waiting = world.exchange.waiting
            self._send({r: m for r, m in world.open_tick().items() if r in waiting})

    def _expect(self, robot: int) -> None:
        """Wait for the next life of a restarted robot."""
        expected, running = self._admissions.processes.expected, self._run.phase is Phase.RUNNING
        so_far = expected.get(robot, 0)
        if running and so_far < self._restarts and self._run.world.lives.expect(robot):
            expected[robot] = so_far + 1

    def _warn_operator(self, robot: int, reason: str) -> None:
        self._warn(f"tick {self._run.world.tick}: gives up robot {robot}, which {reason}")
