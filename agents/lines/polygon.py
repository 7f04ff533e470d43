"""A small convex polygon: where the own centre may be, seen from where it is said to be.

Coordinates are relative to a point that the owner keeps, so that their rounding is that of the polygon's own
size. Cuts may have any direction; those of measurements come from `DIRECTIONS` only, so that their number,
and with it the polygon's corners, stays bounded.
"""

from __future__ import annotations

import math
from typing import Final, final

from mypy_extensions import mypyc_attr

SIDES: Final = 16  # a disk is taken for the polygon of so many sides around it: 2 % too wide at the corners
DIRECTIONS: Final = [
    (math.cos(2.0 * math.pi * side / SIDES), math.sin(2.0 * math.pi * side / SIDES)) for side in range(SIDES)
]
_MOST: Final = 2 * SIDES  # corners


@final
@mypyc_attr(acyclic=True)
class Polygon:
    """Corners (xs[i], ys[i]) in counterclockwise order, m, and all points within `margin` (m) of them."""

    __slots__ = ("_far", "margin", "xs", "ys")

    def __init__(self, xs: list[float], ys: list[float], margin: float = 0.0) -> None:
        self.xs, self.ys, self.margin = xs, ys, margin
        self._far = -1.0  # distance of the farthest corner; not known yet

    def extent(self, nx: float, ny: float) -> float:
        """Support in the direction of the unit vector (nx, ny): the largest n.x, m; exact."""
        farthest = -math.inf
        for index, x in enumerate(self.xs):
            along = nx * x + ny * self.ys[index]
            farthest = max(farthest, along)
        return farthest + self.margin

    def extents(self) -> list[float]:
        """Support in each of the `DIRECTIONS`, m."""
        return [self.extent(nx, ny) for nx, ny in DIRECTIONS]

    @property
    def radius(self) -> float:
        """Of the smallest disk around (0, 0) that contains it, m."""
        if self._far < 0.0:
            square = 0.0
            for index, x in enumerate(self.xs):
                y = self.ys[index]
                square = max(square, x * x + y * y)
            self._far = math.sqrt(square)
        return self._far + self.margin

    def centre(self) -> tuple[float, float]:
        """Of the upright rectangle around it, m."""
        xs, ys = self.xs, self.ys
        return 0.5 * (min(xs) + max(xs)), 0.5 * (min(ys) + max(ys))

    def shifted(self, dx: float, dy: float) -> Polygon:
        """The same, moved by (dx, dy), m."""
        return Polygon([x + dx for x in self.xs], [y + dy for y in self.ys], self.margin)

    def cut(self, nx: float, ny: float, limit: float) -> Polygon | None:
        """What of it satisfies n.x <= limit (m) for the unit vector n; None when nothing does.

        The margin remains around what is left.
        """
        limit += self.margin
        xs: list[float] = []
        ys: list[float] = []
        px, py = self.xs[-1], self.ys[-1]
        before = limit - nx * px - ny * py
        for index, x in enumerate(self.xs):
            y = self.ys[index]
            room = limit - nx * x - ny * y
            if (room < 0.0) != (before < 0.0):
                part = before / (before - room)
                xs.append(px + part * (x - px))
                ys.append(py + part * (y - py))
            if room >= 0.0:
                xs.append(x)
                ys.append(y)
            px, py, before = x, y, room
        if not xs:
            return None
        left = Polygon(xs, ys, self.margin)
        return left if len(xs) <= _MOST else left.widened(0.0)

    def widened(self, radius: float) -> Polygon:
        """The polygon with sides in the `DIRECTIONS` around all that is within `radius` (m) of it."""
        return circumscribed([each + radius - self.margin for each in self.extents()], self.margin)


def circumscribed(extents: list[float], margin: float = 0.0) -> Polygon:
    """The polygon whose support in each of the `DIRECTIONS` is given, m; each must be attained."""
    xs: list[float] = []
    ys: list[float] = []
    sine = 1.0 / math.sin(2.0 * math.pi / SIDES)
    for side, here in enumerate(extents):
        (ax, ay), (bx, by) = DIRECTIONS[side - 1], DIRECTIONS[side]
        last = extents[side - 1]
        xs.append((last * by - here * ay) * sine)
        ys.append((here * ax - last * bx) * sine)
    return Polygon(xs, ys, margin)


def around(radius: float, margin: float = 0.0) -> Polygon:
    """The polygon around the disk of that radius (m) around (0, 0)."""
    return circumscribed([radius] * SIDES, margin)
