"""Positions that a body may pass within a tick: the one definition that plant, filter, proof and tests share.

A tick begins with the control point q at q(0) and the nominal velocity v0, in the frame of the body, and its
command leads to v1; without one, v1 = v0. The nominal way (`protocol.bodies.kinematics`), drawn from q(0),
is at p(t) after a length w(t). Until the base takes another velocity than zero,

    |q(t) - p(t)| <= error w(t) + lag d + play,        d = max(|v0|, |v1|, |v1 - v0|),

from the first instant on. d is the largest change of velocity between rest and the two ends of the tick: a
wheel that follows what it is told with a time constant T is behind by T times the change. A base that stands
stays where it is.

The sweep is the set of all such q(t) - q(0) until the base stands. An arc lies in the triangle of its ends
and of the point where its tangents meet, and for the point after the share u of it, the first end counts in
that triangle for at most 1 - u. So the sweep lies in the convex hull of finitely many disks.

**External bases.** A velocity is decided at time 0. The newest odometry is of the time -a, 0 <= a <= A; q(0)
above is q(-a). Let u(t) be the velocity due at t, in the body's frame, and W(u) the turning rate that it
makes: u(t) was told for t < 0, leads evenly from v0 to v1 in the tick, is v1 for the hold time, and then
brakes. At t the base executes u(g(t)), where t - L <= g(t) <= t is anything: each velocity takes effect
within the latency L after it is due, half of it for a late process, which later commands rest
(`agents.bases.drive`). Let B be the velocities told since -A - L, v0 among them, and

    V = max |b| for b in B,      m = max(|b - v0|, |b - v1|) for b in B,
    s = L (variation of W(u) from -A - L to the end of the tick) + S max |W(b)| for b in B.

S is half of the time by which the prediction of the heading at 0 may be off. Between the path of u(g) from -a
and the nominal way at the same time t are

    the integral of |u(g)| from -a to 0, at most                                    A V,
    that of |u(g) - u| from 0 on: g reaches back into B only until L, and then by
        L into an even change from v0 to v1, at most                                L (m + |v1 - v0|),
    and that of the angle between both, at most s, as |u(g(x)) - u(x)| is at
        most the variation from x - L to x, over the way so far:                    2 sin(s / 2) w(t).

All of it counts for `error`, too. After the hold time both are on the same circle, and the nominal way, which
brakes L later, leads further. So with E = error + 2 sin(s / 2)

    |q(t) - q(-a) - p(t)| <= E w(t) + lag d + play + (1 + E) (A V + L (m + |v1 - v0|)),

where d counts all of B; V counts v1, too, so that the next tick has room to go on with it. A base that is
told to brake within the tick, or whose robot's process dies, goes on with one of the tick's velocities for at
most L + timeout and brakes, on the circle of that velocity: these arcs branch off the nominal way, and are in
the sweep. That of braking before any velocity of the tick is due is in the sweep of the tick before.
"""

from __future__ import annotations

import math
from typing import Final, final

from mypy_extensions import mypyc_attr

from protocol.bodies.kinematics import Arc, Kinematics, Motion, chord, turned
from protocol.messages import Vector
from protocol.scenario.body import Body, Lateness

_TURN: Final = 0.5  # rad; an arc that turns further is cut


@final
@mypyc_attr(acyclic=True)
class Tolerance:
    """Largest deviation of a control point from its nominal path.

    Args:
        noise: added to the `error` of `body`, per length.
        heading: error of the direction of the nominal path, rad.
        late: delays of an external base; None for any other.
    """

    __slots__ = ("_age", "_lag", "_latency", "_offset", "_play", "_spread", "alone", "error")

    def __init__(
        self, body: Body, noise: float = 0.0, heading: float = 0.0, late: Lateness | None = None
    ) -> None:
        self.error = body.error + noise + 2.0 * math.sin(0.5 * heading)  # per length
        self._lag, self._play = body.lag, body.play
        self._offset = body.offset if body.kind == "differential-drive" else 0.0
        # alone: time for which a base may hold a velocity of the tick's middle, s; negative if never.
        self._age, self._latency, self.alone, self._spread = (0.0, 0.0, -1.0, 0.0) if late is None else late

    def share(self, motion: Motion, to: Vector) -> float:
        """The error per length of a tick that leads from a motion to a velocity."""
        if self._offset == 0.0 or self.alone < 0.0:
            return self.error
        fastest, varied, last = abs(motion.aside), abs(to[1] - motion.aside), motion.aside
        for _, aside in reversed(motion.before):
            fastest, varied, last = max(fastest, abs(aside)), varied + abs(aside - last), aside
        askew = (self._latency * varied + self._spread * fastest) / self._offset
        return self.error + 2.0 * math.sin(0.5 * min(askew, math.pi))

    def slip(self, motion: Motion, to: Vector) -> float:
        """The error independent of the length, m, of a tick that leads from a motion to a velocity."""
        ahead, aside = to
        fastest = math.hypot(motion.ahead, motion.aside)
        change = math.hypot(ahead - motion.ahead, aside - motion.aside)
        off = change
        for x, y in motion.before:
            fastest = max(fastest, math.hypot(x, y))
            off = max(off, math.hypot(x - motion.ahead, y - motion.aside), math.hypot(x - ahead, y - aside))
        fastest = max(fastest, math.hypot(ahead, aside))
        slip = self._lag * max(fastest, off) + self._play
        if self.alone >= 0.0:
            late = self._age * fastest + self._latency * (off + change)
            slip += (1.0 + self.share(motion, to)) * late
        return slip


@final
@mypyc_attr(acyclic=True)
class Sweep:
    """The convex hull of disks around points (xs[i], ys[i]), m, of radius `margins[i]`, relative to the
    first, the origin.
    """

    __slots__ = ("margins", "middle", "radius", "spread", "xs", "ys")

    def __init__(self, xs: list[float], ys: list[float], margins: list[float]) -> None:
        self.xs, self.ys, self.margins = xs, ys, margins
        mx, my = 0.5 * xs[-1], 0.5 * ys[-1]
        self.middle = mx, my  # halfway to the last point, m
        self.radius = 0.0  # of a disk around the origin that contains it, m
        self.spread = 0.0  # radius of a disk around `middle` that contains it, m
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
    """Positions of the control point from the beginning of a tick to its stop without another command.

    Args:
        motion: at the beginning of the tick.
        to: reachable velocity at the end of the tick, ahead and aside; None without a command in this tick.
    """
    if to is None:
        to = motion.ahead, motion.aside
        arcs = [kinematics.halt(motion)]
    else:
        arcs = kinematics.drive(motion, *to)
        arcs.append(kinematics.halt(kinematics.driven(motion, *to)))
    error, slip = tolerance.share(motion, to), tolerance.slip(motion, to)
    hull = _Hull(error, slip)
    x = y = way = 0.0
    heading = motion.heading
    for arc in arcs:
        if tolerance.alone >= 0.0 and arc is not arcs[-1]:
            last = Motion(heading, arc.ahead, arc.aside, arc.duration + tolerance.alone)
            hull.follow(kinematics, kinematics.halt(last), x, y, heading, way)
        x, y, heading, way = hull.follow(kinematics, arc, x, y, heading, way)
    return Sweep(hull.xs, hull.ys, hull.margins)


@final
@mypyc_attr(acyclic=True)
class _Hull:
    """Points with margins, m, whose convex hull contains arcs and their surroundings."""

    __slots__ = ("_error", "_slip", "margins", "xs", "ys")

    def __init__(self, error: float, slip: float) -> None:
        self._error, self._slip = error, slip
        self.xs, self.ys, self.margins = [0.0], [0.0], [slip]

    def follow(
        self, kinematics: Kinematics, arc: Arc, x: float, y: float, heading: float, way: float
    ) -> tuple[float, float, float, float]:
        """Add an arc from a point, m, with a heading, rad, after a path length, m; returns those of its end.

        One that goes around more than once lies in its circle, with the margin of its end all around.
        """
        speed = math.hypot(arc.ahead, arc.aside)
        if arc.duration == 0.0 or speed == 0.0:
            return x, y, heading, way
        whole = abs(kinematics.turn(arc))
        around = min(1.0, math.tau / whole) if whole > 0.0 else 1.0  # length of a full circle
        pieces = 1 + int(around * whole / _TURN)
        piece = Arc(arc.ahead, arc.aside, around * arc.duration / pieces)
        turn = kinematics.turn(piece)
        step = speed * piece.duration
        if around < 1.0:
            way, step = way + speed * arc.duration, 0.0
        for _ in range(pieces):
            way += step
            dx, dy = chord(piece, turn, heading)
            if turn != 0.0:
                tangent = piece.duration * math.tan(0.5 * turn) / turn
                tx, ty = turned(piece.ahead * tangent, piece.aside * tangent, heading)
                self._append(x + tx, y + ty, way)
            x, y, heading = x + dx, y + dy, heading + turn
            self._append(x, y, way)
        if around < 1.0:  # the rest, from where the circle began
            rest = Arc(arc.ahead, arc.aside, (1.0 - around) * arc.duration)
            dx, dy = chord(rest, kinematics.turn(rest), heading)
            x, y, heading = x + dx, y + dy, heading + kinematics.turn(rest)
            self._append(x, y, way)
        return x, y, heading, way

    def _append(self, x: float, y: float, way: float) -> None:
        self.xs.append(x)
        self.ys.append(y)
        self.margins.append(self._error * way + self._slip)
