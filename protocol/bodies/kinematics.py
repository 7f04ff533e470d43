"""The nominal motion of a body: a base that holds its velocity, brakes in finite time, and turns with its
wheels.

Its velocity is that of the control point q, in the frame of the body: ahead, and aside to the left. On two
wheels, q lies a distance l ahead of the axle's middle, so that the body's speed is `ahead` and its turning
rate `aside / l`: any velocity of q is possible at once, but for the limits. While both are constant, q
describes an arc. A base of another kind does not turn, and its arcs are straight.

A tick with a command consists of equal arcs, whose velocities change evenly to the commanded one. The zero
velocity means to brake. A tick without a command continues the motion for the rest of the hold time, and then
brakes. Braking scales both wheels by one factor, so that it follows the same circle.

A point is a base that takes every velocity at once and stands at the end of the tick.
"""

from __future__ import annotations

import math
from typing import Final, final

from mypy_extensions import mypyc_attr

from protocol.messages import Vector
from protocol.scenario.body import Body

_STEPS: Final = 5  # successive wheel velocities in a tick, or in `_RAMP`
_RAMP: Final = 0.1  # s; longer ticks have more, so that servos can follow each step
_TURNING: Final = 3.0  # rad; arcs that turn further may have the chord of a shorter one
_TINY: Final = 1e-100  # m, m/s: smaller values are zero, others are valid divisors
_NEARLY: Final = 1.0 + 1e-12  # rounding of a limited velocity


@final
@mypyc_attr(acyclic=True)
class Motion:
    """Motion of a base: velocity of its control point in its own frame, m/s; direction, rad; time for which
    it still holds that velocity without commands, s; and earlier velocities, oldest first, which a late base
    may still execute. Immutable.
    """

    __slots__ = ("ahead", "aside", "before", "heading", "hold")

    def __init__(
        self,
        heading: float,
        ahead: float = 0.0,
        aside: float = 0.0,
        hold: float = 0.0,
        before: tuple[Vector, ...] = (),
    ) -> None:
        self.heading, self.ahead, self.aside, self.hold = heading, ahead, aside, hold
        self.before = before

    @property
    def velocity(self) -> Vector:
        """Of the control point in the world's frame, m/s."""
        return turned(self.ahead, self.aside, self.heading)

    @property
    def stands(self) -> bool:
        """Whether it does not move."""
        return self.ahead == 0.0 and self.aside == 0.0 and not self.before


@final
@mypyc_attr(acyclic=True)
class Arc:
    """A velocity in the frame of the body, m/s, held for a duration, s."""

    __slots__ = ("ahead", "aside", "duration")

    def __init__(self, ahead: float, aside: float, duration: float) -> None:
        self.ahead, self.aside, self.duration = ahead, aside, duration


def steps_of(period: float) -> int:
    """Number of arcs in a tick of `period`, s."""
    return _STEPS * max(1, math.ceil(period / _RAMP - 1e-9))


@final
@mypyc_attr(acyclic=True)
class Kinematics:
    """The kinematics of one body; `period` is that of a tick, s."""

    def __init__(self, body: Body, period: float) -> None:
        wheeled = body.kind == "differential-drive"
        self.period = period
        self._instant = body.kind == "point"
        self._offset = body.offset if wheeled else 0.0
        self._half_track = 0.5 * body.track
        self._speed, self._acceleration, self._hold = body.speed, body.acceleration, body.hold
        self.steps = steps_of(period)  # arcs in a tick
        # Of the control point, m/s.
        self.top_speed = self._speed * max(1.0, self._offset / self._half_track if wheeled else 1.0)

    def turn(self, arc: Arc) -> float:
        """Angle by which an arc turns the body, rad."""
        return arc.aside * arc.duration / self._offset if self._offset > 0.0 else 0.0

    def rim(self, ahead: float, aside: float) -> float:
        """Speed of the faster wheel's rim; without wheels, of the whole, m/s."""
        if self._offset > 0.0:
            return abs(ahead) + abs(aside) * self._half_track / self._offset
        return math.hypot(ahead, aside)

    def limited(self, motion: Motion, velocity: Vector) -> Vector:
        """The executable part of a commanded velocity (m/s, world's frame): ahead and aside at the end of the
        tick, both wheels scaled by one factor to their top speed and acceleration.
        """
        ahead, aside = turned(velocity[0], velocity[1], -motion.heading)
        if not math.isfinite(ahead + aside):
            return 0.0, 0.0
        rim = self.rim(ahead, aside)
        if rim > self._speed * _NEARLY:
            ahead, aside = ahead * self._speed / rim, aside * self._speed / rim
        more, less = ahead - motion.ahead, aside - motion.aside
        change, most = self.rim(more, less), self._acceleration * self.period
        if change > most * _NEARLY:
            ahead, aside = motion.ahead + more * most / change, motion.aside + less * most / change
        return ahead, aside

    def drive(self, motion: Motion, ahead: float, aside: float) -> list[Arc]:
        """The arcs of a tick towards a reachable velocity."""
        if self._instant:
            return [Arc(ahead, aside, self.period)]
        more, less = ahead - motion.ahead, aside - motion.aside
        arcs = []
        for step in range(self.steps):
            part = (step + 0.5) / self.steps
            arcs.append(Arc(motion.ahead + part * more, motion.aside + part * less, self.period / self.steps))
        return arcs

    def driven(self, motion: Motion, ahead: float, aside: float) -> Motion:
        """The motion at the end of that tick."""
        if self._instant:
            return Motion(motion.heading)
        heading = motion.heading
        for arc in self.drive(motion, ahead, aside):
            heading += self.turn(arc)
        return Motion(heading, ahead, aside, self._hold)

    def braking(self, motion: Motion) -> Motion:
        """The same motion under the command to stand: nothing is held."""
        return Motion(motion.heading, motion.ahead, motion.aside, 0.0, motion.before)

    def coast(self, motion: Motion, duration: float) -> Arc:
        """The motion in a time without commands, s, as an arc at the present velocity of equal length."""
        held = min(motion.hold, duration)
        rest = min(duration - held, self._stopping(motion))
        lost = self._lost(motion)
        return Arc(motion.ahead, motion.aside, held + rest - 0.5 * lost * rest * rest)

    def coasted(self, motion: Motion, duration: float) -> Motion:
        """The motion after that time."""
        held = min(motion.hold, duration)
        rest = duration - held
        heading = motion.heading + self.turn(self.coast(motion, duration))
        if rest <= 0.0:
            return Motion(heading, motion.ahead, motion.aside, motion.hold - held)
        left = 1.0 - self._lost(motion) * rest
        if rest >= self._stopping(motion) or left <= 0.0:
            return Motion(heading)
        return Motion(heading, motion.ahead * left, motion.aside * left, 0.0)

    def halt(self, motion: Motion) -> Arc:
        """The whole further motion without commands, as one arc."""
        return Arc(motion.ahead, motion.aside, motion.hold + 0.5 * self._stopping(motion))

    def stop(self, motion: Motion) -> Vector:
        """Displacement of that motion, in the world's frame, m."""
        arc = self.halt(motion)
        return chord(arc, self.turn(arc), motion.heading)

    def unled(self, motion: Motion, *, ordered: bool) -> tuple[list[Arc], Motion]:
        """The arcs of a tick without a velocity, whether a stop is `ordered` or there is no command, and the
        motion at its end."""
        part, arcs = self.period / self.steps, []
        after = self.braking(motion) if ordered else motion
        for _ in range(self.steps):
            arcs.append(self.coast(after, part))
            after = self.coasted(after, part)
        return arcs, after

    def motion(
        self, velocity: Vector, heading: float, stop: Vector, before: tuple[Vector, ...] = ()
    ) -> Motion:
        """The motion that a base reports, in the world's frame: velocity (m/s), heading (rad), and the vector
        (m) to its stop without commands. If it may turn by half a circle until then, which the vector does
        not show, its longest possible motion.
        """
        ahead, aside = turned(velocity[0], velocity[1], -heading)
        speed = math.hypot(ahead, aside)
        if speed < _TINY:
            return Motion(heading, before=before)
        still = Motion(heading, ahead, aside)
        chord, rate = math.hypot(*stop), aside / self._offset if self._offset > 0.0 else 0.0
        if abs(rate) * (self._hold + 0.5 * self._stopping(still)) > _TURNING:
            return Motion(heading, ahead, aside, self._hold, before)
        half = abs(rate) * chord / (2.0 * speed)
        time = chord / speed * (math.asin(min(1.0, half)) / half if half > 1e-9 else 1.0)
        return Motion(heading, ahead, aside, max(0.0, time - 0.5 * self._stopping(still)), before)

    def lead(self, motion: Motion, velocity: Vector) -> Vector:
        """Displacement from the middle of a tick's path, motion.velocity * period / 2 from its beginning, to
        the stop after a velocity (m/s, world's frame) in that tick only, m; as if the base did not turn.
        """
        time = self._held_for + self._slowing(motion, velocity) * math.hypot(*velocity)
        return velocity[0] * time, velocity[1] * time

    def velocity_for(self, motion: Motion, lead: Vector) -> Vector:
        """The velocity with that `lead`, m/s."""
        distance = math.hypot(*lead)
        if distance < _TINY:
            return 0.0, 0.0
        time = self._held_for
        root = math.sqrt(time * time + 4.0 * self._slowing(motion, lead) * distance)
        return 2.0 * lead[0] / (time + root), 2.0 * lead[1] / (time + root)

    def reach(self, speed: float) -> float:
        """The longest path from the beginning of a tick to a stop, m, for commands up to `speed`, m/s."""
        speed = min(speed, self.top_speed)
        if self._instant:
            return speed * self.period
        wheels = math.hypot(1.0, self._half_track / self._offset) if self._offset > 0.0 else 1.0
        stopping = min(wheels * speed, self._speed) / self._acceleration
        return speed * (self.period + self._hold + 0.5 * stopping)

    @property
    def _held_for(self) -> float:
        """Time for which a velocity acts, with half of the tick that leads to it, s."""
        return self.period if self._instant else 0.5 * self.period + self._hold

    def _slowing(self, motion: Motion, direction: Vector) -> float:
        """Braking distance from a velocity in that direction, divided by its squared length, s^2/m."""
        length = math.hypot(*direction)
        if length < _TINY or self._instant:
            return 0.0
        ahead, aside = turned(direction[0], direction[1], -motion.heading)
        return 0.5 * self.rim(ahead, aside) / (length * self._acceleration)

    def _stopping(self, motion: Motion) -> float:
        return self.rim(motion.ahead, motion.aside) / self._acceleration

    def _lost(self, motion: Motion) -> float:
        """Relative decrease of the velocity per second of braking."""
        rim = self.rim(motion.ahead, motion.aside)
        return self._acceleration / rim if rim > 0.0 else 0.0


def turned(x: float, y: float, angle: float) -> Vector:
    """(x, y) turned by an angle, rad."""
    if angle == 0.0:
        return x, y
    cosine, sine = math.cos(angle), math.sin(angle)
    return cosine * x - sine * y, sine * x + cosine * y


def chord(arc: Arc, turn: float, heading: float) -> Vector:
    """Displacement of the control point along an arc that turns the body by `turn`, rad, from a heading, rad,
    in the world's frame, m."""
    if turn == 0.0:
        return turned(arc.ahead * arc.duration, arc.aside * arc.duration, heading)
    sine = math.sin(0.5 * turn)
    along, across = math.sin(turn) / turn, 2.0 * sine * sine / turn
    return turned(
        (along * arc.ahead - across * arc.aside) * arc.duration,
        (across * arc.ahead + along * arc.aside) * arc.duration,
        heading,
    )
