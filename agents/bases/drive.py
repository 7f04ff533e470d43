"""Velocities for a base, computed from Commands, so that it moves like its body in `protocol.bodies`.

A tick's command becomes several velocities; the last one is held until the next tick, but at most for the
patience after the tick, and until the end of the lease: then the robot brakes the base. If this process dies
instead, the base brakes by its own timeout.

A process that is late by more than half of the latency brakes from the last velocity: as the sweep counts it
for one that died, or before any velocity of the tick in the sweep of the tick before. If the base may have
begun to brake by itself, it is to rest: on the same circle, no farther. How far is unknown, so ticks have
no odometry until the base certainly stands, and the odometry is from after that.
"""

from __future__ import annotations

import math
from collections import deque
from itertools import groupby
from typing import Final

from protocol.bodies.kinematics import Arc, Kinematics, Motion, chord, turned
from protocol.messages import BaseMotion, Vector
from protocol.scenario.body import DECISION, Base, Body

OFTEN: Final = 3.0  # least number of velocities within the base's own timeout
_STILL: Vector = (0.0, 0.0)


class Lease:
    """The time for which one life of a robot may move without a Tick of the coordinator.

    Each Tick names the newest of the robot's Commands that the coordinator has received; the coordinator
    declares no robot static before its lease has certainly ended. The lease begins when that Command is sent,
    by the robot's own clock: clocks have to agree in rate, not in time.

    Args:
        duration: s.

    Attributes:
        until: its end, s, by the clock of this process.
    """

    def __init__(self, duration: float) -> None:
        self.until = -math.inf
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
        base: its times.
        period: of a tick, s.

    Attributes:
        told: present velocity for the base.
        due: time of its next change, s; infinite if there is none.
    """

    def __init__(self, body: Body, base: Base, period: float) -> None:
        self.told: Vector = _STILL
        self.due = math.inf
        self._base, self._kinematics = base, Kinematics(body, period)
        self._hold, self._grace = body.hold, period + base.patience
        self._part = period / self._kinematics.steps
        self._late = base.lateness
        self._slack = 0.5 * base.latency
        self._gap = base.timeout / OFTEN + self._slack
        self._rest = self._late.alone + self._late.window + body.speed / body.acceleration
        self._plan: deque[tuple[float, Vector]] = deque()
        self._past: deque[tuple[float, Vector]] = deque([(-math.inf, _STILL)])
        self._published = -math.inf  # s
        self._until = -math.inf  # s, start of braking without a command
        self._unknown = -math.inf  # s, end of unknown motion

    def advance(self, now: float) -> None:
        """Advance to `now`, when `told` is published; if that is late, brake."""
        self._check(now)
        before, self._published = self.told, now
        if self._plan and self._plan[0][0] < min(self._until, now - self._slack):
            self._until = now
            self._plan = deque(self._brake(now, self.told))
        while self._plan and self._plan[0][0] <= now:
            _, self.told = self._plan.popleft()
        if self.told != before:
            self._past.append((now, self.told))
        self.due = self._plan[0][0] if self._plan else math.inf

    def motion(self, heading: float, now: float) -> BaseMotion | None:
        """The motion that follows from the velocities sent, the last of which is held until the command of
        the new tick; None while it is unknown.

        Args:
            heading: in the map, rad.
            now: s.
        """
        self._check(now)
        if now < self._unknown:
            return None
        if not self._brakes:
            self._plan = deque(self._brake(max(now, self._until), self.told))
        while len(self._past) > 1 and self._past[1][0] <= now - self._late.window:
            self._past.popleft()
        before = tuple(each for each, _ in groupby(velocity for _, velocity in self._past))
        if before == (_STILL,):
            return BaseMotion(_STILL, heading, _STILL)
        hold = min(self._late.alone + max(0.0, self._until - now), self._hold)
        arc = self._kinematics.halt(Motion(heading, *self.told, hold))
        dx, dy = turned(*chord(arc, self._kinematics.turn(arc)), heading)
        return BaseMotion(turned(*self.told, heading), heading, (dx, dy), before)

    def turning(self, age: float, now: float) -> float:
        """Rotation of the base from its odometry of an estimated age, s, to the command of the new tick, rad,
        within `Lateness.spread` except for late effects.
        """
        latency, delay = self._base.latency, self._base.delay
        turn, end = self._kinematics.turn(Arc(*self.told, 0.5 * DECISION)), now
        for begin, velocity in reversed(self._past):
            duration = end - max(begin, now - age - 0.5 * (latency - delay))
            if duration > 0.0:
                turn, end = turn + self._kinematics.turn(Arc(*velocity, duration)), begin
        return turn

    def command(self, velocity: Vector, heading: float, now: float, until: float) -> None:
        """Set the velocity of the tick that begins.

        Args:
            velocity: of the control point in the map, m/s; zero means to brake.
            heading: in the map, rad.
            now: s.
            until: end of the lease, s.
        """
        self._check(now)
        if now < self._unknown or (velocity == _STILL and self._brakes):
            return
        motion = Motion(heading, *self.told)
        self._until = max(now, min(now + self._grace, until))
        plan: list[tuple[float, Vector]] = []
        if velocity != _STILL:
            ahead, aside = self._kinematics.limited(motion, velocity)
            arcs = self._kinematics.drive(motion, ahead, aside)
            plan = [(now + n * self._part, (arc.ahead, arc.aside)) for n, arc in enumerate(arcs)]
            plan.append((now + len(arcs) * self._part, (ahead, aside)))
            plan = [step for step in plan if step[0] < self._until]
        else:
            self._until = now
        self._plan = deque([*plan, *self._brake(self._until, plan[-1][1] if plan else self.told)])
        self.due = self._plan[0][0] if self._plan else math.inf

    def _check(self, now: float) -> None:
        """Command rest if the base may have begun to brake by itself."""
        if self.told == _STILL or now - self._published <= self._gap:
            return
        self.told, self._until, self._unknown = _STILL, now, now + self._rest
        self._plan.clear()
        self._past.append((now, _STILL))

    @property
    def _brakes(self) -> bool:
        """Whether it was told to brake: what is left of that is due in time, however many ticks begin."""
        return self._past[-1][0] >= self._until

    def _brake(self, begin: float, velocity: Vector) -> list[tuple[float, Vector]]:
        kinematics = self._kinematics
        steps: list[tuple[float, Vector]] = []
        coasting = Motion(0.0, *velocity)
        while not coasting.stands:
            arc = kinematics.coast(coasting, self._part)
            share = arc.duration / self._part
            steps.append((begin + len(steps) * self._part, (share * arc.ahead, share * arc.aside)))
            coasting = kinematics.coasted(coasting, self._part)
        return [*steps, (begin + len(steps) * self._part, _STILL)] if steps else []
