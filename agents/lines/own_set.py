"""The set of possible positions of the own centre: a small convex polygon, and its support.

Coordinates of a polygon are relative to a point that its owner keeps, so that rounding errors scale with the
polygon. Cuts may have any direction, but those of measurements are in `DIRECTIONS` only, so that the number
of corners stays bounded.
"""

from __future__ import annotations

import math
from typing import Final, final

from mypy_extensions import mypyc_attr

from protocol.bodies.sweep import Sweep
from protocol.kernel.robot import OwnEnd
from protocol.line import ROUNDING, SURE, HalfPlane, Line
from protocol.region import Region, is_beside

SIDES: Final = 16  # of the polygon around a disk: 2 % too wide at the corners
DIRECTIONS: Final = [
    (math.cos(2.0 * math.pi * side / SIDES), math.sin(2.0 * math.pi * side / SIDES)) for side in range(SIDES)
]
_MOST: Final = 2 * SIDES  # corners


@final
@mypyc_attr(acyclic=True)
class Polygon:
    """Corners (xs[i], ys[i]) in counterclockwise order, m, and all points within `margin` (m) of them."""

    def __init__(self, xs: list[float], ys: list[float], margin: float = 0.0) -> None:
        self.xs, self.ys, self.margin = xs, ys, margin
        self._far = -1.0  # distance of the farthest corner; -1: not computed yet

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
        """Radius of the smallest disk around (0, 0) that contains it, m."""
        if self._far < 0.0:
            square = 0.0
            for index, x in enumerate(self.xs):
                y = self.ys[index]
                square = max(square, x * x + y * y)
            self._far = math.sqrt(square)
        return self._far + self.margin

    def centre(self) -> tuple[float, float]:
        """Centre of its bounding box, m."""
        xs, ys = self.xs, self.ys
        return 0.5 * (min(xs) + max(xs)), 0.5 * (min(ys) + max(ys))

    def shifted(self, dx: float, dy: float) -> Polygon:
        """The polygon moved by (dx, dy), m."""
        return Polygon([x + dx for x in self.xs], [y + dy for y in self.ys], self.margin)

    def cut(self, nx: float, ny: float, limit: float) -> Polygon | None:
        """The part with n.x <= limit (m) for the unit vector n, if there is any, with the same margin."""
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
        """The polygon with sides in the `DIRECTIONS` around all points within `radius` (m) of it."""
        return circumscribed([each + radius - self.margin for each in self.extents()], self.margin)


def circumscribed(extents: list[float], margin: float = 0.0) -> Polygon:
    """The polygon with these supports in the `DIRECTIONS`, m; each must be attained."""
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


@final
@mypyc_attr(acyclic=True)
class OwnSet:
    """All possible positions of the own centre at the start of a tick, with its further motion. Immutable.

    Args:
        x, y: the own position, m.
        bound: greatest distance of the centre from there, m; infinite while it is unknown.
        shape: the set as seen from there; None: the disk of radius `bound`.
        swept: sweep of the centre from there until all commands have ended; None: it stands.
    """

    def __init__(
        self, x: float, y: float, bound: float, shape: Polygon | None = None, swept: Sweep | None = None
    ) -> None:
        self.x, self.y, self.bound = x, y, bound
        self.shape, self.swept = shape, swept

    def extent(self, nx: float, ny: float) -> float:
        """Support of the set from the estimated position in the direction (nx, ny), m."""
        return self.bound if self.shape is None else self.shape.extent(nx, ny)

    def passed(self, nx: float, ny: float) -> float:
        """Support of the set with its further motion, m."""
        extent = self.extent(nx, ny)
        if self.swept is not None:
            extent += self.swept.extent(nx, ny)
        return extent

    def satisfies(self, side: HalfPlane) -> bool:
        """Whether the centre is surely in a half-plane until every sent command has ended."""
        return side.slack(self.x, self.y) >= self.passed(side.nx, side.ny) + SURE

    def within(self, x: float, y: float, radius: float) -> bool:
        """Whether the set with its further motion is surely in the disk of that radius around (x, y), m."""
        mx, my, spread = self.x, self.y, self.bound
        if self.swept is not None:
            ax, ay = self.swept.middle
            mx, my, spread = mx + ax, my + ay, spread + self.swept.spread
        return math.hypot(mx - x, my - y) + spread + 2.0 * ROUNDING <= radius

    def kept_in(self, nx: float, ny: float, limit: float) -> HalfPlane:
        """Half-plane of the estimated position that keeps the whole set in the given one."""
        return HalfPlane(nx, ny, limit - (self.extent(nx, ny) + 2.0 * ROUNDING))


@final
class Cover:
    """All that a robot covers now and until no command has any effect: a disk with its centre in a set, m."""

    def __init__(self, own: OwnSet, radius: float) -> None:
        self.own, self.radius = own, radius


@final
class CoverGeometry:
    """Implements `protocol.kernel.robot.RobotGeometry`."""

    def inside(self, body: Cover, region: Region) -> bool:
        """Whether a body is in a region."""
        shape, own = region.shape.around, body.own
        return own.within(shape.x, shape.y, shape.radius - body.radius)

    def fits(self, body: Cover, line: Line, low: bool) -> bool:
        """Whether a body is on one side of a line."""
        return line.is_unit and body.own.satisfies(line.side(body.radius, low))

    def behind(self, place: Region, line: Line, low: bool) -> bool:
        """Whether a place is on one side of a line."""
        return is_beside(place.shape, line, low)

    def keeps(self, body: Cover, end: OwnEnd[Region, Line]) -> bool:
        """Whether a body is on the own side of all obeyed lines of a binding."""
        return all(self.fits(body, line, end.low) for line in end.obeyed)
