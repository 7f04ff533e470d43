"""What is done to a fleet while it endures: a process killed now and then, a cable pulled now and then."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field
from math import inf
from random import Random
from typing import NamedTuple

from deploy.processes.table import ROUTER, WORLD, robot_name

CUT = 8.0  # s that a cable is out: longer than a token may be missing, so that its robot's life is ended


class Blow(NamedTuple):
    """One disturbance: a process to kill by name, or the robot whose cable to pull."""

    kill: str | None = None
    cut: int | None = None


@dataclass
class Disturbances:
    """When, and who: robots by lot, and with every tenth kill the router, with every tenth the world.

    Only robots that are under way are hit, so that it can be seen when they are again.

    Args:
        kill_every, cut_every: s; 0 for never. Cuts come between kills.
        rng: draws the robots.
    """

    kill_every: float
    cut_every: float
    rng: Random = field(default_factory=lambda: Random(0))
    _kills: int = 0
    _cuts: int = 0

    def due(self, elapsed: float, under_way: Collection[int]) -> Blow | None:
        """What is to be done `elapsed` s after the first tick; None if nothing is due."""
        if not under_way:
            return None
        robot = self.rng.choice(sorted(under_way))
        if elapsed >= self._next_kill:
            self._kills += 1
            return Blow(kill={5: ROUTER, 0: WORLD}.get(self._kills % 10, robot_name(robot)))
        if elapsed >= self._next_cut:
            self._cuts += 1
            return Blow(cut=robot)
        return None

    @property
    def _next_kill(self) -> float:
        return (self._kills + 1) * self.kill_every if self.kill_every else inf

    @property
    def _next_cut(self) -> float:
        return (self._cuts + 1) * self.cut_every + 0.5 * self.kill_every if self.cut_every else inf
