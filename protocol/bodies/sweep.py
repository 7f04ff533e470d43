"""Positions that a body may pass within a tick: the one definition that plant, filter, proof and tests share.

A tick begins with the control point q at q(0) and the nominal velocity v0, in the frame of the body, and its
command leads to v1; without one, v1 = v0. The nominal way (`protocol.bodies.kinematics`), drawn from q(0),
is at p(t) after a length w(t). Until the base takes another velocity than zero,

    |q(t) - p(t)| <= error w(t) + lag d + play,        d = max(|v0|, |v1|, |v1 - v0|),

from the first instant on. d is the largest change of velocity between rest and the two ends of the tick: a
wheel that follows what it is told with a time constant T is behind by T times the change. Of a base whose
odometry is late, q(0) is where that has it, and d the largest change among these and all velocities that it
was told in the last `lag`: it has done, or still does, what it was told then. A base that stands stays where
it is.

The sweep is the set of all such q(t) - q(0) until the base stands. An arc lies in the triangle of its ends
and of the point where its tangents meet, and for the point after the share u of it, the first end counts in
that triangle for at most 1 - u. So the sweep lies in the convex hull of finitely many disks.
"""

from __future__ import annotations

import math
from typing import Final, final

from mypy_extensions import mypyc_attr

from protocol.bodies.kinematics import Arc, Kinematics, Motion, Vector, chord, turned
from protocol.scenario.body import Body

_TURN: Final = 0.5  # rad; an arc that turns further is cut


@final
@mypyc_attr(acyclic=True)
class Tolerance:
    """How far a control point may be from its nominal way.

    Args:
        body: which states that.
        noise: what is added to its `error`, a share of the way.
        heading: rad, by which the direction may be off in which the nominal way is drawn.
    """

    __slots__ = ("_lag", "_play", "error")

    def __init__(self, body: Body, noise: float = 0.0, heading: float = 0.0) -> None:
        self.error = body.error + noise + 2.0 * math.sin(0.5 * heading)
        self._lag, self._play = body.lag, body.play

    def slip(self, motion: Motion, to: Vector) -> float:
        """The part that does not grow with the way, m, of a tick that leads from a motion to a velocity."""
        ahead, aside = to
        change = max(
            math.hypot(motion.ahead, motion.aside),
            math.hypot(ahead, aside),
            math.hypot(ahead - motion.ahead, aside - motion.aside),
        )
        for x, y in motion.before:
            more, less = math.hypot(x - motion.ahead, y - motion.aside), math.hypot(x - ahead, y - aside)
            change = max(change, math.hypot(x, y), more, less)
        return self._lag * change + self._play


@final
@mypyc_attr(acyclic=True)
class Sweep:
    """The convex hull of disks around points (xs[i], ys[i]), m, of radius `margins[i]`; the first is the
    origin, as the others are seen from there.

    Attributes:
        radius: of a disk around the origin that contains it, m.
        middle: halfway to the last point, m.
        spread: radius of a disk around that which contains it, m.
    """

    __slots__ = ("margins", "middle", "radius", "spread", "xs", "ys")

    def __init__(self, xs: list[float], ys: list[float], margins: list[float]) -> None:
        self.xs, self.ys, self.margins = xs, ys, margins
        mx, my = 0.5 * xs[-1], 0.5 * ys[-1]
        self.middle = mx, my
        self.radius = self.spread = 0.0
        for index, x in enumerate(xs):
            y, margin = ys[index], margins[index]
            self.radius = max(self.radius, math.hypot(x, y) + margin)
            self.spread = max(self.spread, math.hypot(x - mx, y - my) + margin)

    def extent(self, nx: float, ny: float) -> float:
        """Support in the direction of the unit vector (nx, ny), m, at least 0."""
        most = 0.0
        for index, x in enumerate(self.xs):
            most = max(most, nx * x + ny * self.ys[index] + self.margins[index])
        return most


def sweep(kinematics: Kinematics, motion: Motion, tolerance: Tolerance, to: Vector | None = None) -> Sweep:
    """Positions of the control point from the beginning of a tick until it stands without another command.

    Args:
        kinematics: of the body.
        motion: what it does as the tick begins.
        tolerance: by how much it may be off.
        to: velocity that the tick leads to, ahead and aside, which the base can reach; None: it hears nothing
            in this tick either.
    """
    if to is None:
        slip = tolerance.slip(motion, (motion.ahead, motion.aside))
        arcs = [kinematics.halt(motion)]
    else:
        slip = tolerance.slip(motion, to)
        arcs = kinematics.drive(motion, *to)
        arcs.append(kinematics.halt(kinematics.driven(motion, *to)))
    return _hull(kinematics, motion.heading, arcs, tolerance.error, slip)


def _hull(kinematics: Kinematics, heading: float, arcs: list[Arc], error: float, slip: float) -> Sweep:
    """Arcs, one after another, with what is around them. One that goes around more than once lies in its
    circle, with the margin of its end all around."""
    xs, ys, margins = [0.0], [0.0], [slip]
    x = y = way = 0.0
    for arc in arcs:
        speed = math.hypot(arc.ahead, arc.aside)
        if arc.duration == 0.0 or speed == 0.0:
            continue
        whole = abs(kinematics.turn(arc))
        around = min(1.0, math.tau / whole) if whole > 0.0 else 1.0  # of the arc that a circle is
        pieces = 1 + int(around * whole / _TURN)
        piece = Arc(arc.ahead, arc.aside, around * arc.duration / pieces)
        turn = kinematics.turn(piece)
        step = speed * piece.duration
        if around < 1.0:
            way, step = way + speed * arc.duration, 0.0
        for _ in range(pieces):
            way += step
            margin = error * way + slip
            cx, cy = chord(piece, turn)
            dx, dy = turned(cx, cy, heading)
            if turn != 0.0:
                tangent = piece.duration * math.tan(0.5 * turn) / turn
                tx, ty = turned(piece.ahead * tangent, piece.aside * tangent, heading)
                _append(xs, ys, margins, x + tx, y + ty, margin)
            x, y, heading = x + dx, y + dy, heading + turn
            _append(xs, ys, margins, x, y, margin)
        if around < 1.0:  # the rest, from where the circle began
            rest = Arc(arc.ahead, arc.aside, (1.0 - around) * arc.duration)
            cx, cy = chord(rest, kinematics.turn(rest))
            dx, dy = turned(cx, cy, heading)
            x, y, heading = x + dx, y + dy, heading + kinematics.turn(rest)
            _append(xs, ys, margins, x, y, error * way + slip)
    return Sweep(xs, ys, margins)


def _append(
    xs: list[float], ys: list[float], margins: list[float], x: float, y: float, margin: float
) -> None:
    xs.append(x)
    ys.append(y)
    margins.append(margin)
