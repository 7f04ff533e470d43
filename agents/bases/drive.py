"""Velocities for a base, computed from Commands, so that it moves like its body in `protocol.bodies`.

A tick's command becomes several velocities; the last one is held until the next tick, but at most for the
patience after the tick, and until the end of the lease: then the robot brakes the base. If this process dies
instead, the base brakes by its own timeout.

The sweep counts each velocity as if this process, never late by more than half of the latency, died in any
instant. So whatever would be published later than that is replaced by rest: the base brakes as after a death
with the velocity published last, or sooner. A velocity w that is due until e is then executed until e +
latency at most; or it is published before e, and held until e + latency / 2 + timeout. The steps of braking
from e on are at most the velocity of an even braking, so one that is the last leads no farther than w held
until e + latency + timeout, and braking: that is in the sweep. How far a base is that was told to rest is
unknown until it certainly stands: ticks have no odometry until then, and next that from after it.
"""

from __future__ import annotations

import math
from collections import deque
from itertools import groupby
from typing import Final

from protocol.bodies.kinematics import Arc, Kinematics, Motion
from protocol.messages import STILL, BaseMotion, Vector
from protocol.scenario.body import DECISION, Base, Body

OFTEN: Final = 3.0  # least number of velocities within the base's own timeout


class Lease:
    """The time, `duration` s, for which one life of a robot may move without a Tick of the coordinator.

    Each Tick names the newest of the robot's Commands that the coordinator has received; the coordinator
    declares no robot static before its lease has certainly ended. The lease begins when that Command is sent,
    by the robot's own clock: clocks have to agree in rate, not in time.
    """

    def __init__(self, duration: float) -> None:
        self.until = -math.inf  # its end, s, by the clock of this process
        self._duration = duration
        self._sent: dict[int, float] = {}

    def sent(self, tick: int, now: float) -> None:
        """Note the time at which the Command of a tick is sent, perhaps again."""
        self._sent.setdefault(tick, now)

    def heard(self, tick: int | None) -> None:
        """Renew the lease: the coordinator has received the Command of that tick."""
        if tick is None or tick not in self._sent:
            return
        self.until = max(self.until, self._sent[tick] + self._duration)
        self._sent = {other: when for other, when in self._sent.items() if other > tick}


class Drive:
    """One base's velocities, ahead and aside in its own frame, m/s.

    Args:
        body: with all delays.
        period: of a tick, s.
    """

    def __init__(self, body: Body, base: Base, period: float) -> None:
        self.velocity: Vector = STILL  # the present one
        self._base, self._kinematics = base, Kinematics(body, period)
        self._grace = period + base.patience
        self._part = period / self._kinematics.steps
        self._late = base.lateness
        self._rest = self._late.alone + self._late.window + body.speed / body.acceleration
        self._plan: deque[tuple[float, Vector]] = deque()  # velocities of the tick by when they are due
        self._brakes = -math.inf  # s, when the next step of braking is due
        self._past: deque[tuple[float, Vector]] = deque([(-math.inf, STILL)])
        self._published = -math.inf  # s
        self._unknown = -math.inf  # s, end of unknown motion

    @property
    def due(self) -> float:
        """Time of the next publication, s; infinite while the base is to stand."""
        if self.velocity == STILL:
            return self._plan[0][0] if self._plan else math.inf
        return min(self._end, self._published + self._base.timeout / OFTEN)

    def advance(self, now: float) -> None:
        """Advance to `now`, when `velocity` is published."""
        self._check(now)
        before, self._published = self.velocity, now
        while self._plan and self._plan[0][0] <= now:
            _, self.velocity = self._plan.popleft()
        while self.velocity != STILL and self._brakes <= now:
            braked = self._kinematics.coasted(Motion(0.0, *self.velocity), self._part)
            self.velocity, self._brakes = (braked.ahead, braked.aside), self._brakes + self._part
        if self.velocity != before:
            self._past.append((now, self.velocity))

    def motion(self, heading: float, now: float) -> BaseMotion | None:
        """The motion that follows from the velocities sent, the last of which is held for as long as it would
        be without the new tick; None while it is unknown.

        Args:
            heading: in the map, rad.
            now: s.
        """
        self._check(now)
        if now < self._unknown:
            return None
        self._brake(self._end)
        while len(self._past) > 1 and self._past[1][0] <= now - self._late.window:
            self._past.popleft()
        before = tuple(each for each, _ in groupby(velocity for _, velocity in self._past))
        if before == (STILL,):
            return BaseMotion(STILL, heading, STILL)
        hold = self._late.alone + max(0.0, self._brakes - now)
        motion = Motion(heading, *self.velocity, hold)
        return BaseMotion(motion.velocity, heading, self._kinematics.stop(motion), before)

    def turning(self, age: float, now: float) -> float:
        """Rotation of the base from its odometry of an estimated age, s, to the command of the new tick, rad,
        within `Lateness.spread` except for late effects.
        """
        latency, delay = self._base.latency, self._base.delay
        turn, end = self._kinematics.turn(Arc(*self.velocity, 0.5 * DECISION)), now
        for begin, velocity in reversed(self._past):
            duration = end - max(begin, now - age - 0.5 * (latency - delay))
            if duration > 0.0:
                turn, end = turn + self._kinematics.turn(Arc(*velocity, duration)), begin
        return turn

    def command(self, velocity: Vector, heading: float, now: float, until: float) -> None:
        """Set the velocity of the tick that begins; `advance` comes next.

        Args:
            velocity: of the control point in the map, m/s; zero means to brake.
            heading: in the map, rad.
            now: s.
            until: end of the lease, s.
        """
        if now < self._unknown:
            return
        if velocity == STILL or until <= now:
            self._brake(now if self._end > now + self._part else self._end)  # no sooner if it brakes
            return
        motion = Motion(heading, *self.velocity)
        ahead, aside = self._kinematics.limited(motion, velocity)
        arcs = self._kinematics.drive(motion, ahead, aside)
        steps = [*((arc.ahead, arc.aside) for arc in arcs), (ahead, aside)]
        self._brake(min(now + self._grace, until))
        plan = ((now + n * self._part, step) for n, step in enumerate(steps))
        self._plan.extend(step for step in plan if step[0] < self._brakes)

    @property
    def _end(self) -> float:
        """Time until which `velocity` is due, s."""
        return self._plan[0][0] if self._plan else self._brakes

    def _brake(self, begin: float) -> None:
        """Brake from `begin` on, s."""
        self._brakes = begin
        self._plan.clear()

    def _check(self, now: float) -> None:
        """Command rest, unless all that was due until half of the latency ago was published."""
        if now <= self.due + 0.5 * self._base.latency:
            return
        self._plan.clear()
        if self.velocity != STILL:
            self.velocity, self._unknown = STILL, self._published + self._rest
            self._past.append((now, STILL))
