"""The run of one world."""

from __future__ import annotations

import secrets
import time
from collections import Counter
from collections.abc import Iterable
from enum import Enum
from typing import Any

from protocol.messages import Clock, Health, Tick
from protocol.scenario.model import Scenario
from world.report import result_of
from world.world import Past, World


def traffic(
    reports: Iterable[Health | None], published: int, received: int, rejected: Counter[str]
) -> dict[str, object]:
    """`published` and `received` (accepted) messages and those rejected by reason, over all processes.

    Args:
        reports: last words of the robots that gave any.
        published, received, rejected: the world's own counts.
    """
    total = Counter(rejected)
    for health in reports:
        if health is not None:
            published += health.published
            received += health.received
            total.update(health.rejected)
    return {"published": published, "received": received, "rejected": dict(sorted(total.items()))}


def drawn_epoch() -> int:
    """A coordinator's number (`protocol.messages.Epoch`), which no other one has."""
    return 1 + secrets.randbelow(2**32 - 1)


class Phase(Enum):
    """RUNNING (or gathering), SHUTDOWN (robots report), CLOSING (they are told to leave)."""

    RUNNING = 1
    SHUTDOWN = 2
    CLOSING = 3


class Run:
    """A run with its judge, from its beginning or from where an earlier world has left it.

    Attributes:
        phase: how far the run is.
        starters: robots with which it begins.
        opened: whether the present tick has begun.
        began: s, monotonic: when its first tick began, or when it was prepared.
        received, rejected: commands accepted, and payloads refused by reason.
    """

    def __init__(self, scenario: Scenario, past: Past = Past(), *, returning: float = 0.0) -> None:
        self.phase = Phase.RUNNING
        self.world = World(scenario, past, returning=returning)
        self.starters = frozenset(scenario.ids)
        self.opened = False
        self.began = time.monotonic()
        self.received = 0
        self.rejected: Counter[str] = Counter()
        self._due = {scenario.ticks(fault.at) for fault in scenario.process}

    @property
    def scenario(self) -> Scenario:
        """The scenario, with the robots that are there now."""
        return self.world.scenario

    def clock(self) -> Clock:
        """What the clock says now."""
        world, truth = self.world, self.world.truth
        seconds = world.tick * self.scenario.time.step
        return Clock(
            world.tick,
            seconds,
            world.coordinator.active,
            world.coordinator.lives.standing,
            world.verdict,
            truth.clearance,
            truth.phi,
            world.reason,
            world.coordinator.lives.founded,
            world.coordinator.halted,
            world.coordinator.commands.missed,
            dict(self.rejected),
            world.coordinator.lives.obstacles.changes,
            world.coordinator.newcomers,
            world.coordinator.parts.places,
            world.coordinator.lives.passed_over,
        )

    def is_marked(self) -> bool:
        """Whether something is to happen at this tick that a launcher has to carry out."""
        return self.world.tick in self._due or bool(self.world.coordinator.newcomers)

    def final_ticks(self, robots: Iterable[int]) -> dict[int, Tick]:
        """What tells robots that the run is over."""
        lives, tick = self.world.coordinator.lives.incarnations, self.world.tick
        return {robot: Tick(robot, lives[robot], tick, (), over=True) for robot in robots}

    def report(self, healths: Iterable[Health | None], published: int, ended: float) -> dict[str, Any]:
        """The world's report with the traffic of all processes and the wall time up to `ended`."""
        report = result_of(self.world)
        report["messages"] = traffic(healths, published, self.received, self.rejected)
        report["wall_time"] = ended - self.began
        return report
