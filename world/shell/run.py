"""The run of one world, and its end: robots report, and then receive the verdict.

A robot learns from a Tick that the run is over, and asks to join again with its report. It is told to ask
again until all have reported, and then receives the verdict. Both waits are bounded.
"""

from __future__ import annotations

import secrets
import time
from collections import Counter
from enum import Enum
from typing import Any, Final

from protocol import joining
from protocol.messages import Clock, Tick, Truth
from protocol.scenario.model import Scenario
from world.past import Past
from world.report import result_of
from world.shell.admission import Admissions
from world.shell.pacing import Pacing
from world.world import WorldCore

_HALF: Final = 2**31  # half of all epochs


def drawn_epoch(*, continues: bool = False) -> int:
    """A unique number of a coordinator (`protocol.messages.Epoch`), in the lower half if it continues a run:
    of two with runs that have not begun, the one with the lower number stays."""
    return 1 + secrets.randbelow(_HALF - 1) + (0 if continues else _HALF)


class Phase(Enum):
    """RUNNING (or gathering), SHUTDOWN (robots report), CLOSING (robots leave)."""

    RUNNING = 1
    SHUTDOWN = 2
    CLOSING = 3


class JudgedRun:
    """A run with its judge, from its beginning or continued from an earlier world."""

    def __init__(self, scenario: Scenario, past: Past = Past(), *, returning: float = 0.0) -> None:
        self.phase = Phase.RUNNING
        self.world = WorldCore(scenario, past, returning=returning)
        self.opened = False  # whether the present tick has begun
        self.began = time.monotonic()  # s, monotonic: beginning of its first tick, or of its preparation
        self.received = 0  # Commands accepted
        self.rejected: Counter[str] = Counter()  # payloads refused, by reason
        self._due = {scenario.ticks(fault.at) for fault in scenario.process}

    @property
    def scenario(self) -> Scenario:
        return self.world.scenario

    def clock(self) -> Clock:
        """The present Clock."""
        world, totals = self.world, self.world.referee.record.totals
        return Clock(
            tick=world.tick,
            time=world.tick * self.scenario.time.step,
            active=world.exchange.active,
            standing=world.lives.roster.standing,
            verdict=world.verdict,
            clearance=totals.clearance,
            phi=totals.truth.phi,
            reason=world.referee.reason,
            founded=world.lives.founded,
            halted=world.halted,
            missed=world.exchange.missed,
            rejected=dict(self.rejected),
            obstacles=world.lives.obstacles.changes,
            newcomers=world.lives.newcomers,
            parts=world.parts.places,
            passed_over=world.lives.passed_over,
            stops=world.stops,
        )

    def news(self) -> list[Truth]:
        """Truths to publish; none before the run begins, when a recorder may not be listening yet."""
        begun = self.world.lives.founded or self.world.verdict
        return self.world.referee.record.news() if begun else []

    def is_marked(self) -> bool:
        """Whether this tick has an event that a launcher executes."""
        return self.world.tick in self._due or bool(self.world.lives.newcomers)


SHUTDOWN = 2.0  # s, time for robots to report after the end, and to be informed
_ASK_AGAIN = 0.005  # s between requests of robots that have reported before others


class Shutdown:
    """Tracks which robots have reported and which are informed, and decides whether that is enough."""

    def __init__(self, run: JudgedRun, admissions: Admissions, pacing: Pacing) -> None:
        self._run, self._admissions, self._pacing = run, admissions, pacing

    def begin(self) -> None:
        """Begin after a verdict: robots report."""
        self._run.phase = Phase.SHUTDOWN
        self._pacing.wait()

    def close(self) -> None:
        """Continue after the result: robots leave."""
        self._run.phase = Phase.CLOSING
        self._pacing.wait()

    def take_report(self, join: joining.Join) -> None:
        """Take the report of an ended life from a request to join, if it has one."""
        if self._run.phase is Phase.SHUTDOWN:
            slot = self._admissions.slots[join.robot]
            slot.health = join.health or slot.health

    def reply(self, join: joining.Join) -> joining.JoinReply | None:
        """The reply to a request to join while a run ends; None while it runs."""
        if self._run.phase is Phase.SHUTDOWN:
            return joining.Wait(_ASK_AGAIN, "the run is being wound up")
        if self._run.phase is Phase.CLOSING:
            self._admissions.slots[join.robot].notified = True
            return joining.Finished(self._run.world.verdict)
        return None

    def instead(self, refusal: joining.JoinReply, robot: int) -> joining.JoinReply:
        """The reply to a process that cannot take part, which need not wait at the end."""
        if self._run.phase is not Phase.CLOSING or not isinstance(refusal, joining.Wait):
            return refusal
        self._admissions.dismiss(robot)
        return joining.Finished(self._run.world.verdict)

    def final_ticks(self) -> dict[int, Tick]:
        """Ticks that announce the end of the run to uninformed robots."""
        reports, world = self._run.phase is Phase.SHUTDOWN, self._run.world
        robots = self._admissions.owing_health() if reports else self._admissions.unnotified()
        lives, tick = world.lives.incarnations, world.tick
        return {robot: Tick(robot, lives[robot], tick, (), over=True) for robot in robots}

    def is_reported(self) -> bool:
        """Whether the robots have reported, or their time is over."""
        return self._run.phase is Phase.SHUTDOWN and (
            not self._admissions.owing_health() or self._is_overdue()
        )

    def is_over(self) -> bool:
        """Whether all processes are informed of the end, or their time is over."""
        admissions = self._admissions
        left = not (admissions.unnotified() or admissions.is_asked_soon())
        return self._run.phase is Phase.CLOSING and (left or self._is_overdue())

    def report(self, published: int = 0) -> dict[str, Any]:
        """The result of the run up to its verdict, with the traffic of all processes: messages `published`
        and received (accepted), and those rejected by reason."""
        received, rejected = self._run.received, Counter(self._run.rejected)
        for slot in self._admissions.slots.values():
            if slot.health is not None:
                published += slot.health.published
                received += slot.health.received
                rejected.update(slot.health.rejected)
        counts = {"published": published, "received": received, "rejected": dict(sorted(rejected.items()))}
        wall_time = self._pacing.since - self._run.began
        return {**result_of(self._run.world), "messages": counts, "wall_time": wall_time}

    def _is_overdue(self) -> bool:
        return self._pacing.waited() > SHUTDOWN
