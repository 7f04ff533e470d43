"""Everything that a control point passes on its way, as a set around where it is now."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, final

from mypy_extensions import mypyc_attr

from protocol.bodies.base import Arc, Base, Motion, chord, turned

_TURN: Final = 0.5  # rad; an arc that turns further is cut


@final
@mypyc_attr(acyclic=True)
class Sweep:
    """The convex hull of the origin and of disks around points (xs[i], ys[i]), m, of radius `margins[i]`.

    Attributes:
        radius: of a disk around the origin that contains it, m.
        middle: halfway to the last point, m.
        spread: radius of a disk around that which contains it, m.
    """

    __slots__ = ("margins", "middle", "radius", "spread", "xs", "ys")

    def __init__(self, xs: list[float], ys: list[float], margins: list[float]) -> None:
        self.xs, self.ys, self.margins = xs, ys, margins
        mx, my = (0.5 * xs[-1], 0.5 * ys[-1]) if xs else (0.0, 0.0)
        self.middle = mx, my
        self.radius, self.spread = 0.0, math.hypot(mx, my)
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


@final
@mypyc_attr(acyclic=True)
class Miss:
    """By how much a control point may miss where it is sent: having gone a way L, at a speed of at most v so
    far, by at most `error` L + `lag` v + `play`. `error` is a share, `lag` in s, `play` in m."""

    __slots__ = ("error", "lag", "play")

    def __init__(self, error: float = 0.0, lag: float = 0.0, play: float = 0.0) -> None:
        self.error, self.lag, self.play = error, lag, play


def sweep(base: Base, motion: Motion, arcs: Sequence[Arc], *, miss: Miss, rise: int) -> Sweep:
    """What the control point passes along arcs, one after another, if it may miss them.

    Of the lag and the play there is only an even share in each of the first `rise` arcs; with none, all of it
    at once. Each arc lies in the triangle of its ends and of the point where its tangents meet; one that goes
    around more than once, in its circle, with the margin of its end all around.

    Args:
        base: that describes them.
        motion: what it does as it begins.
        miss: by how much it may be off.
        rise: in how many arcs lag and play become what they are.
    """
    xs: list[float] = []
    ys: list[float] = []
    margins: list[float] = []
    x = y = way = 0.0
    heading, fastest = motion.heading, math.hypot(motion.ahead, motion.aside)
    for index, arc in enumerate(arcs):
        speed = math.hypot(arc.ahead, arc.aside)
        if arc.duration == 0.0 or (speed == 0.0 and rise == 0):
            continue  # what stands has no lag; while it turns back, lag and play grow
        whole = abs(base.turn(arc))
        around = min(1.0, math.tau / whole) if whole > 0.0 else 1.0  # of the arc that a circle is
        pieces = 1 + int(around * whole / _TURN)
        piece = Arc(arc.ahead, arc.aside, around * arc.duration / pieces)
        turn = base.turn(piece)
        step = speed * piece.duration
        if around < 1.0:
            way, step = way + speed * arc.duration, 0.0
        fastest = max(fastest, speed)
        late = (miss.lag * fastest + miss.play) * (min(1.0, (index + 1) / rise) if rise > 0 else 1.0)
        if late > 0.0 and rise == 0 and not xs:
            xs, ys, margins = [0.0], [0.0], [late]
        for _ in range(pieces):
            way += step
            cx, cy = chord(piece, turn)
            dx, dy = turned(cx, cy, heading)
            if turn != 0.0:
                tangent = piece.duration * math.tan(0.5 * turn) / turn
                tx, ty = turned(piece.ahead * tangent, piece.aside * tangent, heading)
                _append(xs, ys, margins, x + tx, y + ty, miss.error * way + late)
            x, y, heading = x + dx, y + dy, heading + turn
            _append(xs, ys, margins, x, y, miss.error * way + late)
        if around < 1.0:  # the rest, from where the circle began
            rest = Arc(arc.ahead, arc.aside, (1.0 - around) * arc.duration)
            cx, cy = chord(rest, base.turn(rest))
            dx, dy = turned(cx, cy, heading)
            x, y, heading = x + dx, y + dy, heading + base.turn(rest)
            _append(xs, ys, margins, x, y, miss.error * way + late)
    return Sweep(xs, ys, margins)


def _append(
    xs: list[float], ys: list[float], margins: list[float], x: float, y: float, margin: float
) -> None:
    xs.append(x)
    ys.append(y)
    margins.append(margin)
