"""Everything that a control point passes on its way, as a set around where it is now."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, final

from mypy_extensions import mypyc_attr

from protocol.bodies.base import Arc, Base, chord, turned

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


def sweep(base: Base, heading: float, arcs: Sequence[Arc], *, error: float, lag: float, rise: int) -> Sweep:
    """What the control point passes along arcs, one after another, if it may miss them.

    It is away from where the arcs lead, having gone a way L along them, by at most `error` L + `lag`, and of
    the lag only an even share in each of the first `rise` arcs; with none, all of it at once. Each arc lies
    in the triangle of its ends and of the point where its tangents meet.

    Args:
        base: that describes them.
        heading: at the beginning, rad.
        error: share of the way.
        lag: m.
        rise: in how many arcs the lag becomes what it is.
    """
    xs: list[float] = []
    ys: list[float] = []
    margins: list[float] = []
    x = y = way = 0.0
    for index, arc in enumerate(arcs):
        speed = math.hypot(arc.ahead, arc.aside)
        if speed == 0.0 or arc.duration == 0.0:
            continue
        pieces = 1 + int(abs(base.turn(arc)) / _TURN)
        piece = Arc(arc.ahead, arc.aside, arc.duration / pieces)
        turn = base.turn(piece)
        late = lag * min(1.0, (index + 1) / rise) if rise > 0 else lag
        if late > 0.0 and rise == 0 and not xs:
            xs, ys, margins = [0.0], [0.0], [late]
        for _ in range(pieces):
            way += speed * piece.duration
            cx, cy = chord(piece, turn)
            dx, dy = turned(cx, cy, heading)
            if turn != 0.0:
                tangent = piece.duration * math.tan(0.5 * turn) / turn
                tx, ty = turned(piece.ahead * tangent, piece.aside * tangent, heading)
                _append(xs, ys, margins, x + tx, y + ty, error * way + late)
            x, y, heading = x + dx, y + dy, heading + turn
            _append(xs, ys, margins, x, y, error * way + late)
    return Sweep(xs, ys, margins)


def _append(
    xs: list[float], ys: list[float], margins: list[float], x: float, y: float, margin: float
) -> None:
    xs.append(x)
    ys.append(y)
    margins.append(margin)
