"""What a watcher knows of one robot, and the row in which it is told."""

from __future__ import annotations

import math
from typing import Any

from deploy.telemetry.scene.thinned import Thinned
from protocol.messages import GoalStatus, Health, Line, Vector
from protocol.scenario.model import RobotSpec

SILENCE = 1.5  # s behind its peers after which a robot counts as silent
ALARMS = ("dead", "fenced", "silent")
ABANDONED = ("cancelled", "given up")  # the robot stays where it was then
_DIGITS = 6  # micrometres are enough for a picture


class RobotView:
    """One robot as it is seen from outside; times are seconds on the watcher's own clock."""

    def __init__(self, spec: RobotSpec, trail: int, first: int | None = 1) -> None:
        """Args:
        spec: the robot in the scenario.
        trail: how many places it was at are kept, at most.
        first: incarnation of its first life in this scenario; None: the first one seen.
        """
        self.spec = spec
        self.radius = spec.radius  # m, of its disk, with what it carries
        self.alive: bool | None = None  # None: no token seen yet
        self.fenced = False
        self.active = False
        self.incarnation = 0
        self.tick = 0  # of its newest state, as far as anybody told
        self.health: Health | None = None
        self.lines: tuple[Line, ...] = ()  # that it obeyed at its latest health, to peers near it
        self.errand = GoalStatus(spec.id, 0, 0, "under way", spec.goal)
        self.position: Vector = spec.start
        self.velocity: Vector = (0.0, 0.0)
        self.trail: Thinned[Vector] = Thinned(trail, lambda _, later: later)
        self._first = first
        self._said: float | None = None
        self._reported = 0.0
        self._rate: float | None = None

    def said(self, tick: int, now: float) -> None:
        """Somebody knows of this robot's state of `tick`."""
        if tick > self.tick or self._said is None:
            self.tick, self._said = tick, now

    def report(self, health: Health, now: float) -> None:
        """Take over what the robot says about itself; what an earlier life said late is ignored."""
        if health.incarnation < self.incarnation:
            return
        if health.incarnation > self.incarnation:
            self.incarnation, self._rate = health.incarnation, None
            self._first = health.incarnation if self._first is None else self._first
        elif self.health is not None and now > self._reported:
            # Every State goes with a Command, and these two are what a robot publishes once a tick.
            self._rate = max(0, health.published - self.health.published) / 2.0 / (now - self._reported)
        self.health, self._reported = health, now
        self.said(health.tick, now)

    def ordered(self, status: GoalStatus) -> None:
        """Take over what came of an order, unless something newer is known."""
        if (status.number, status.tick) >= (self.errand.number, self.errand.tick):
            self.errand = status

    def moved(self, position: Vector, seconds: float) -> None:
        """Where it really is, `seconds` of simulated time after where it was last."""
        x, y = self.position
        if seconds > 0.0:
            self.velocity = ((position[0] - x) / seconds, (position[1] - y) / seconds)
        self.position = position
        self.trail.append(position)

    @property
    def restarts(self) -> int:
        """How often it began anew."""
        return max(0, self.incarnation - (self._first or 0)) if self.incarnation else 0

    @property
    def distance(self) -> float:
        """To the present goal, m."""
        return math.dist(self.position, self.errand.goal)

    def age(self, now: float) -> float | None:
        """Seconds since its newest state; None before the first."""
        return None if self._said is None else max(0.0, now - self._said)

    def status(self, now: float, newest: int, tolerance: float, *, ended: bool = False) -> str:
        """One word; those in `ALARMS` ask for attention.

        `newest`: tick of the newest state of all robots. `ended`: there is a verdict.
        """
        if self.fenced and not self.active:
            return "fenced"
        if self.alive is False:
            return "dead"
        if not ended and self._said is None and not self.active:
            return "joining" if self.alive else "absent"
        if not ended and self.tick < newest and (self.age(now) or 0.0) > SILENCE:
            return "silent"
        if self.distance <= tolerance:
            return self.errand.status if self.errand.status in ABANDONED else "at goal"
        return "stopped" if ended else "under way"

    def row(self, now: float, newest: int) -> dict[str, Any]:
        """What the table says, without the status."""
        health, age = self.health, self.age(now)
        silent = age is None or age > SILENCE
        return {
            "id": self.spec.id,
            "alive": self.alive,
            "radius": self.radius,
            "velocity": [round(part, _DIGITS) for part in self.velocity],
            "distance": round(self.distance, _DIGITS),
            "goal": self.errand.goal,
            "ahead": self.errand.ahead,
            "age": None if age is None else round(age, 2),
            "age_ticks": None if age is None else newest - self.tick,
            "rate": 0.0 if silent else self._rate,
            "bound": None if health is None else health.bound,
            "rejected": 0 if health is None else sum(health.rejected.values()),
            "reasons": {} if health is None else health.rejected,
            "restarts": self.restarts,
            "lines": self.lines,
            "lines_tick": None if health is None else health.tick,
        }
