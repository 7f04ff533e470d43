"""Closed convex sets of the plane: disks and polygons, as obstacles or around a workspace. Lengths in m."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from typing import final

from mypy_extensions import mypyc_attr

Point = tuple[float, float]
Side = tuple[float, float, float]  # outward unit normal, and the largest n.p, m
SIDES = 48  # corners of a polygon in place of a disk
ROOM = 0  # the boundary, among numbers of obstacles
_SHORT = 1e-9  # m, least length of a side, so that its direction is exact enough
_STRAIGHT = 1e-9  # sine of a turn below which a corner is ignored
_THIN = 1e-6  # least width of a polygon over its length


@final
@mypyc_attr(acyclic=True)
class Disk:
    """All points within `radius` of (x, y), m. Immutable."""

    __slots__ = ("radius", "x", "y")

    def __init__(self, x: float, y: float, radius: float) -> None:
        self.x, self.y, self.radius = x, y, radius

    def __repr__(self) -> str:
        return f"Disk({self.x!r}, {self.y!r}, {self.radius!r})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Disk) and self._numbers == other._numbers

    def __hash__(self) -> int:
        return hash(self._numbers)

    @property
    def _numbers(self) -> tuple[float, float, float]:
        return self.x, self.y, self.radius

    @property
    def around(self) -> Disk:
        """The smallest known disk that contains it."""
        return self

    @property
    def box(self) -> tuple[Point, Point]:
        """Lower left and upper right corner of its bounding box, m."""
        return (self.x - self.radius, self.y - self.radius), (self.x + self.radius, self.y + self.radius)

    def distance(self, x: float, y: float) -> float:
        """Distance of (x, y), m; inside, minus the distance to the edge."""
        return math.hypot(self.x - x, self.y - y) - self.radius

    def nearest(self, x: float, y: float) -> Point:
        """The nearest point to (x, y), which is itself inside."""
        dx, dy = x - self.x, y - self.y
        distance = math.hypot(dx, dy)
        if distance <= self.radius:
            return x, y
        scale = self.radius / distance
        return self.x + scale * dx, self.y + scale * dy

    def support(self, nx: float, ny: float) -> float:
        """The largest n.p of its points p, n = (nx, ny) a unit vector, m."""
        return nx * self.x + ny * self.y + self.radius

    def outline(self, sides: int = SIDES) -> list[Point]:
        """Corners of a regular polygon on its edge, counterclockwise, m."""
        angles = [math.tau * side / sides for side in range(sides)]
        return [
            (self.x + self.radius * math.cos(angle), self.y + self.radius * math.sin(angle))
            for angle in angles
        ]


@final
@mypyc_attr(acyclic=True)
class ConvexPolygon:
    """The convex hull of corners in either sense of rotation, m, that have no `defect`. Immutable."""

    __slots__ = ("around", "points", "sides")

    def __init__(self, points: Sequence[Point]) -> None:
        corners = [(float(x), float(y)) for x, y in points]
        if signed_area(corners) < 0.0:
            corners.reverse()
        self.points = tuple(corners)  # counterclockwise
        # Each as (nx, ny, offset), in the order of the corners that they begin at.
        self.sides = tuple([_side(corners, index) for index in range(len(corners))])
        self.around = _around(corners)  # a disk that contains it

    def __repr__(self) -> str:
        return f"ConvexPolygon({self.points!r})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ConvexPolygon) and self.points == other.points

    def __hash__(self) -> int:
        return hash(self.points)

    @property
    def box(self) -> tuple[Point, Point]:
        """Lower left and upper right corner of its bounding box, m."""
        xs, ys = [x for x, _ in self.points], [y for _, y in self.points]
        return (min(xs), min(ys)), (max(xs), max(ys))

    def distance(self, x: float, y: float) -> float:
        highest = -math.inf
        for nx, ny, offset in self.sides:
            highest = max(highest, nx * x + ny * y - offset)
        if highest <= 0.0:
            return highest
        px, py = self.nearest(x, y)
        return math.hypot(px - x, py - y)

    def nearest(self, x: float, y: float) -> Point:
        least, best = math.inf, (x, y)
        ax, ay = self.points[-1]
        for bx, by in self.points:
            ux, uy, vx, vy = bx - ax, by - ay, x - ax, y - ay
            if ux * vy < uy * vx:  # only sides that face the point can be nearest
                part = (vx * ux + vy * uy) / (ux * ux + uy * uy)
                if 0.0 < part < 1.0:  # and straight from one there is no nearer point
                    return ax + part * ux, ay + part * uy
                part = 0.0 if part <= 0.0 else 1.0
                px, py = ax + part * ux, ay + part * uy
                square = (px - x) * (px - x) + (py - y) * (py - y)
                if square < least:
                    least, best = square, (px, py)
            ax, ay = bx, by
        return best

    def support(self, nx: float, ny: float) -> float:
        most = -math.inf
        for x, y in self.points:
            most = max(most, nx * x + ny * y)
        return most

    def outline(self) -> list[Point]:
        """Its corners, counterclockwise, m."""
        return list(self.points)


Shape = Disk | ConvexPolygon


def shape_of(points: Sequence[Point], radius: float) -> Shape:
    """A shape from its form in messages: the disk around one point, or the polygon of several corners, m."""
    if len(points) == 1:
        return Disk(points[0][0], points[0][1], radius)
    return ConvexPolygon(points)


def points_of(shape: Shape) -> tuple[tuple[Point, ...], float]:
    """The reverse of `shape_of`."""
    if isinstance(shape, Disk):
        return ((shape.x, shape.y),), shape.radius
    return shape.points, 0.0


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
    """A disk around the middle of its bounding box."""
    xs, ys = [x for x, _ in corners], [y for _, y in corners]
    x, y = 0.5 * (min(xs) + max(xs)), 0.5 * (min(ys) + max(ys))
    return Disk(x, y, max([math.hypot(px - x, py - y) for px, py in corners]))


def defect(points: Sequence[Point]) -> str:
    """Why corners form no convex polygon, "" if they do; they may run in either sense."""
    count = len(points)
    if count < 3:
        return "needs at least three points"
    edges = []
    for n, (x, y) in enumerate(points):
        end = points[(n + 1) % count]
        edges.append((end[0] - x, end[1] - y))
        if math.hypot(*edges[n]) < _SHORT:
            return f"points {n} and {(n + 1) % count} are the same, or nearly"
    area, longest = signed_area(points), max([math.hypot(*edge) for edge in edges])
    if abs(area) < _THIN * longest * longest:
        return "has no area: its points are on one line, or its sides cross"
    turns = [_turn(edges[n - 1], edges[n]) for n in range(count)]
    for n, turn in enumerate(turns):
        left = math.copysign(1.0, area) * math.sin(turn)
        if left < (_STRAIGHT if math.cos(turn) < 0.0 else -_STRAIGHT):  # a turn back is one inward
            return f"is not convex at point {n}, or its sides cross"
    return "" if abs(math.fsum(turns)) < 1.5 * math.tau else "goes around more than once"


def _turn(one: Point, other: Point) -> float:
    """From one edge to the next, rad."""
    return math.atan2(one[0] * other[1] - one[1] * other[0], one[0] * other[0] + one[1] * other[1])


def obstructed(room: Shape, shapes: Mapping[int, Shape], radius: float) -> Iterator[tuple[int, int]]:
    """Pairs of obstacles, or of boundary (`ROOM`) and obstacle, between which no disk of `radius` (m) passes.

    Other shapes are replaced by the disks around them.
    """
    disks = {number: shape.around for number, shape in shapes.items()}
    for (one, a), (other, b) in combinations(disks.items(), 2):
        if a.distance(b.x, b.y) - b.radius <= 2.0 * radius:
            yield one, other
    for number, disk in disks.items():
        if -room.distance(disk.x, disk.y) - disk.radius <= 2.0 * radius:
            yield ROOM, number


def is_sphere_world(room: Shape, shapes: Mapping[int, Shape], radius: float) -> bool:
    """Whether the centre of a disk of `radius` (m) moves in a sphere world."""
    round_ = all(isinstance(shape, Disk) for shape in (room, *shapes.values()))
    return round_ and next(obstructed(room, shapes, radius), None) is None
