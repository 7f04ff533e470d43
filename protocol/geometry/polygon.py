"""A convex polygon: a box, a wall segment, a room."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import final

from mypy_extensions import mypyc_attr

from protocol.geometry.disk import Disk

Point = tuple[float, float]
Side = tuple[float, float, float]  # outward unit normal, and the largest n.p, m


@final
@mypyc_attr(acyclic=True)
class ConvexPolygon:
    """The convex hull of its corners. Immutable.

    Args:
        points: corners in either sense of rotation, m, as `protocol.geometry.defects` accepts them.

    Attributes:
        points: the same, counterclockwise.
        sides: each as (nx, ny, offset), in the order of the corners that they begin at.
        around: a disk that contains it.
    """

    __slots__ = ("around", "points", "sides")

    def __init__(self, points: Sequence[Point]) -> None:
        corners = [(float(x), float(y)) for x, y in points]
        if signed_area(corners) < 0.0:
            corners.reverse()
        self.points = tuple(corners)
        self.sides = tuple([_side(corners, index) for index in range(len(corners))])
        self.around = _around(corners)

    def __repr__(self) -> str:
        return f"ConvexPolygon({self.points!r})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ConvexPolygon) and self.points == other.points

    def __hash__(self) -> int:
        return hash(self.points)

    def __reduce__(self) -> tuple[object, ...]:
        return ConvexPolygon, (self.points,)

    @property
    def area(self) -> float:
        """m^2."""
        return signed_area(self.points)

    @property
    def box(self) -> tuple[Point, Point]:
        """The lower left and the upper right corner of the upright rectangle around it, m."""
        xs, ys = [x for x, _ in self.points], [y for _, y in self.points]
        return (min(xs), min(ys)), (max(xs), max(ys))

    def distance(self, x: float, y: float) -> float:
        """Distance of (x, y), m; inside, minus the distance to the edge."""
        highest = -math.inf
        for nx, ny, offset in self.sides:
            highest = max(highest, nx * x + ny * y - offset)
        if highest <= 0.0:
            return highest
        px, py = self.nearest(x, y)
        return math.hypot(px - x, py - y)

    def nearest(self, x: float, y: float) -> Point:
        """The nearest point to (x, y), which is itself inside."""
        least, best, outside = math.inf, (x, y), False
        ax, ay = self.points[-1]
        nx, ny, offset = self.sides[-1]
        for index, (bx, by) in enumerate(self.points):
            if nx * x + ny * y > offset:  # only sides that face the point can be nearest
                outside = True
                ux, uy = bx - ax, by - ay
                part = ((x - ax) * ux + (y - ay) * uy) / (ux * ux + uy * uy)
                part = min(max(part, 0.0), 1.0)
                px, py = ax + part * ux, ay + part * uy
                square = (px - x) * (px - x) + (py - y) * (py - y)
                if square < least:
                    least, best = square, (px, py)
            ax, ay = bx, by
            nx, ny, offset = self.sides[index]
        return best if outside else (x, y)

    def limit(self, nx: float, ny: float, clearance: float) -> float:
        """The largest c so that n.p >= c + clearance for every p of it, n = (nx, ny) a unit vector, m."""
        least = math.inf
        for x, y in self.points:
            least = min(least, nx * x + ny * y)
        return least - clearance

    def outline(self) -> list[Point]:
        """Its corners, counterclockwise, m."""
        return list(self.points)


def signed_area(points: Sequence[Point]) -> float:
    """Area within a closed line, m^2; negative when it runs clockwise."""
    ox, oy = points[0]
    double = 0.0
    ax, ay = points[-1]
    for bx, by in points:
        double += (ax - ox) * (by - oy) - (bx - ox) * (ay - oy)
        ax, ay = bx, by
    return 0.5 * double


def _side(corners: Sequence[Point], index: int) -> Side:
    (ax, ay), (bx, by) = corners[index], corners[(index + 1) % len(corners)]
    length = math.hypot(bx - ax, by - ay)
    nx, ny = (by - ay) / length, (ax - bx) / length
    offset = -math.inf
    for x, y in corners:
        offset = max(offset, nx * x + ny * y)
    return nx, ny, offset


def _around(corners: Sequence[Point]) -> Disk:
    """Around the middle of its upright rectangle."""
    xs, ys = [x for x, _ in corners], [y for _, y in corners]
    x, y = 0.5 * (min(xs) + max(xs)), 0.5 * (min(ys) + max(ys))
    return Disk(x, y, max([math.hypot(px - x, py - y) for px, py in corners]))
