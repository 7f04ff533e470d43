"""Paths among obstacles: clearance on a grid, and distances to a goal over it, by A* (Hart, Nilsson and
Raphael, 1968) from the goal towards the robot.

The time to find a path depends on the area, not on the number of obstacles. A grid shows a passage that is
wider than the robot by one step. A narrower one is found on points that are too close to obstacles by half a
step, and no path leads through a gap that is known to be closed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from heapq import heappop, heappush
from typing import Final

import numpy as np

from agents.law.passages import Gap, crosses
from protocol.arrays import Complexes, Reals
from protocol.geometry import ConvexPolygon, Disk, Shape
from protocol.messages import Vector

MARGIN: Final = 0.02  # clearance of paths from obstacles, own radii
REACH: Final = 8.0  # distance within which obstacles repel, own radii
_STEP: Final = 0.5  # grid step, own radii
_CELL: Final = 0.5  # side of a cell, distances within which obstacles repel
MANY: Final = 64  # obstacles beyond which a grid is finer, and only near obstacles repel
_POINTS: Final = 60_000, 250_000  # most of the grid, with few obstacles and with many
_NEARER: Final = 0.98  # share of its clearance that a robot beside an obstacle has to keep
_BESIDE: Final = 2  # steps within which a robot joins a path
_CLOSEST: Final = 0.5  # least share of its radius that a disk keeps, by the grid, in narrow passages
_INFINITE: Final = math.inf


class Clearances:
    """Distances of points of a grid from obstacles and walls, for robots of one radius, m. Immutable."""

    def __init__(self, room: Shape, shapes: Sequence[Shape], radius: float) -> None:
        (left, low), (right, high) = room.box
        most = _POINTS[len(shapes) > MANY]
        # Between neighbouring points, m.
        self.step = max(_STEP * radius, math.sqrt((right - left) * (high - low) / most))
        self._left, self._low = left - self.step, low - self.step
        self.reach = max(REACH * radius, 2.0 * self.step)
        self.width, self._height = (  # points in a row, and rows
            math.ceil((right - left) / self.step) + 3,
            math.ceil((high - low) / self.step) + 3,
        )
        xs: Reals = self._left + self.step * np.arange(self.width, dtype=np.float64)
        ys: Reals = self._low + self.step * np.arange(self._height, dtype=np.float64)
        clear = np.minimum(self.reach, -distances(room, xs[None, :], ys[:, None]))
        self._cell = _CELL * self.reach
        self._cells: dict[tuple[int, int], list[Shape]] = {}  # what may be near, by column and row
        for shape in shapes:
            self._register(shape)
            (x0, y0), (x1, y1) = shape.box
            i, j = np.searchsorted(xs, (x0 - self.reach, x1 + self.reach)).tolist()
            k, m = np.searchsorted(ys, (y0 - self.reach, y1 + self.reach)).tolist()
            part = clear[k:m, i:j]
            np.minimum(part, distances(shape, xs[None, i:j], ys[k:m, None]), out=part)
        clear[[0, -1], :] = clear[:, [0, -1]] = -self.step  # a rim, so that all others have 8 neighbours
        self._is_coarse = self.step > 2.0 * radius  # walls may lie between two points that are clear of them
        self._sides = _sides(shapes if self._is_coarse else ())
        # At each point, m, row by row; at most `reach`; zero or less outside of the workspace.
        self.clear: list[float] = clear.ravel().tolist()

    def _register(self, shape: Shape) -> None:
        """Add an obstacle to all cells that its surrounding box is within `reach` of."""
        (x0, y0), (x1, y1) = shape.box
        left, low = self._cell_of(x0 - self.reach, y0 - self.reach)
        right, high = self._cell_of(x1 + self.reach, y1 + self.reach)
        for column in range(left, right + 1):
            for row in range(low, high + 1):
                self._cells.setdefault((column, row), []).append(shape)

    def _cell_of(self, x: float, y: float) -> tuple[int, int]:
        return math.floor(x / self._cell), math.floor(y / self._cell)

    def near(self, x: float, y: float) -> list[Shape]:
        """All obstacles within `reach` of (x, y); of others only some whose surrounding disks are."""
        found: list[Shape] = []
        for shape in self._cells.get(self._cell_of(x, y), ()):
            around = shape.around
            far, dx, dy = self.reach + around.radius, around.x - x, around.y - y
            if dx * dx + dy * dy <= far * far:
                found.append(shape)
        return found

    def index(self, x: float, y: float) -> int:
        """Index of the grid point nearest to (x, y)."""
        column = min(max(round((x - self._left) / self.step), 1), self.width - 2)
        row = min(max(round((y - self._low) / self.step), 1), self._height - 2)
        return row * self.width + column

    def place(self, index: int) -> Vector:
        """Position of a grid point, m."""
        row, column = divmod(index, self.width)
        return self._left + column * self.step, self._low + row * self.step

    def _on_grid(self, x: float, y: float) -> Vector:
        """(x, y) in steps of the grid, or the nearest point of the grid's area."""
        u = min(max((x - self._left) / self.step, 0.0), self.width - 1.001)
        return u, min(max((y - self._low) / self.step, 0.0), self._height - 1.001)

    def _between(self, u: float, v: float) -> float:
        """Clearance at a point in steps of the grid, m, interpolated."""
        i, j = int(u), int(v)
        u, v, clear, below = u - i, v - j, self.clear, j * self.width + i
        above = below + self.width
        low = (1.0 - u) * clear[below] + u * clear[below + 1]
        return (1.0 - v) * low + v * ((1.0 - u) * clear[above] + u * clear[above + 1])

    def sees(self, begin: Vector, end: Vector, clear: float) -> bool:
        """Whether the straight line keeps `clear` (m) of everything, or nearly the clearance at its ends.
        Clearance decreases at most as fast as the line proceeds, so spare clearance is skipped.
        """
        u, v = self._on_grid(begin[0], begin[1])
        far_u, far_v = self._on_grid(end[0], end[1])
        needed = min(clear, _NEARER * self._between(u, v), _NEARER * self._between(far_u, far_v))
        du, dv, done = far_u - u, far_v - v, 0.0
        length = self.step * math.sqrt(du * du + dv * dv)
        while done < length:
            part = done / length
            here = self._between(u + part * du, v + part * dv)
            if here < needed:
                return False
            done += max(0.5 * self.step, here - needed)
        return not (self._is_coarse and self._crosses_side(complex(*begin), complex(*end)))

    def _crosses_side(self, begin: complex, end: complex) -> bool:
        """Whether a straight line crosses a side of an obstacle that the grid may not show."""
        one, other = self._sides
        apart = ((end - begin) * (one - begin).conj()).imag * (
            (end - begin) * (other - begin).conj()
        ).imag <= 0.0
        across = ((other - one) * (begin - one).conj()).imag * (
            (other - one) * (end - one).conj()
        ).imag <= 0.0
        return bool((apart & across).any())


clearances = lru_cache(maxsize=16)(Clearances)  # shared by robots of one size in one process


class FieldRoute:
    """Short paths to one goal after the other, for disks of radius `clear`, m.

    Args:
        closed: all gaps that such a disk does not pass, so that paths may use all others; without them paths
            use passages that are wider by a step of the grid.
    """

    def __init__(self, map_: Clearances, clear: float, closed: Sequence[Gap] | None = None) -> None:
        self._map, self._clear = map_, clear * (1.0 + MARGIN)
        self._closed, self._guarded = closed or (), bytearray(len(map_.clear))
        if closed is not None:
            self._clear = max(clear - 0.5 * map_.step, _CLOSEST * clear)
            for gap in closed:
                self._guard(gap)
        width, straight = map_.width, map_.step
        self._steps = [
            (row * width + column, straight * math.hypot(row, column))
            for row in (-1, 0, 1)
            for column in (-1, 0, 1)
            if row or column
        ]
        self._goal: Vector | None = None
        self._focus = 0, 0  # row and column of the robot as the search began
        self._rest: list[float] = []  # distance of each point from the goal, m
        self._next: list[int] = []  # next point of each point's path
        self._settled = bytearray()
        self._open: list[tuple[float, int]] = []
        self._way: list[int] = []  # path found last; _sent: index of the point that the robot heads for
        self._sent = 0
        self._seen: tuple[Vector, Vector, float] | None = None  # from, to, and rest of the path, m

    def ahead(self, position: Vector, goal: Vector) -> tuple[Vector, float] | None:
        """First corner of a short path to the goal, and the path's length, m.

        The goal itself if nothing is in between; None if no path was found.
        """
        if goal != self._goal:
            self._begin(goal, position)
        seen = self._seen
        if seen is None or not self._is_fresh(position, seen[0], seen[1]):
            seen = self._seen = self._look(position, goal)
        return None if seen is None else (seen[1], math.dist(position, seen[1]) + seen[2])

    def _is_fresh(self, position: Vector, begin: Vector, corner: Vector) -> bool:
        """Whether a corner seen from `begin` is still valid: the grid resolves half a step."""
        step = self._map.step
        return math.dist(position, begin) < 0.5 * step and math.dist(position, corner) > step

    def _look(self, position: Vector, goal: Vector) -> tuple[Vector, Vector, float] | None:
        """The farthest visible point of the path, and the rest from there, m."""
        if self._sees(position, goal):
            return position, goal, 0.0
        if not self._way or not self._sees(position, self._map.place(self._way[self._sent])):
            begin = self._join(position)
            if begin is None:
                return None
            self._way, self._sent = self._follow(begin), 0
        self._advance(position)
        index = self._way[self._sent]
        return position, self._map.place(index), self._rest[index]

    def _sees(self, begin: Vector, end: Vector) -> bool:
        return self._map.sees(begin, end, self._clear) and not self._bars(begin, end)

    def _bars(self, begin: Vector, end: Vector) -> bool:
        """Whether a straight line crosses a closed gap."""
        return any(crosses(gap.begin, gap.end, begin, end) for gap in self._closed)

    def _is_barred(self, index: int, other: int) -> bool:
        return self._bars(self._map.place(index), self._map.place(other))

    def _guard(self, gap: Gap) -> None:
        """Mark the points with a neighbour beyond a closed gap."""
        (x0, y0), (x1, y1), width = gap.begin, gap.end, self._map.width
        low, high = self._map.index(min(x0, x1), min(y0, y1)), self._map.index(max(x0, x1), max(y0, y1))
        for row in range(low // width - 1, high // width + 2):
            for column in range(low % width - 1, high % width + 2):
                self._guarded[row * width + column] = 1

    def _begin(self, goal: Vector, position: Vector) -> None:
        count = len(self._map.clear)
        self._focus = divmod(self._map.index(*position), self._map.width)
        self._goal, self._way, self._seen = goal, [], None
        self._rest, self._next, self._settled = [_INFINITE] * count, [-1] * count, bytearray(count)
        self._open = []
        for index in self._around(goal):
            self._rest[index] = math.dist(goal, self._map.place(index))
            heappush(self._open, (self._rest[index] + self._least(index), index))

    def _around(self, place: Vector) -> list[int]:
        centre, reach = self._map.index(*place), range(-_BESIDE, _BESIDE + 1)
        near = [centre + row * self._map.width + column for row in reach for column in reach]
        return [
            index
            for index in near
            if 0 <= index < len(self._map.clear)
            and self._map.clear[index] >= self._clear
            and self._sees(place, self._map.place(index))
        ]

    def _join(self, position: Vector) -> int | None:
        """The point with the shortest path from `position`, if any."""
        best, shortest = None, _INFINITE
        for index in self._around(position):
            length = self._distance(index) + math.dist(position, self._map.place(index))
            if length < shortest:
                best, shortest = index, length
        return best

    def _distance(self, wanted: int) -> float:
        """Distance of a point from the goal, m, by continuing the search as far as needed."""
        clear, rest, settled, open_ = self._map.clear, self._rest, self._settled, self._open
        guarded = self._guarded
        while open_ and not settled[wanted]:
            _, index = heappop(open_)
            if settled[index]:
                continue
            settled[index], length = 1, rest[index]
            for step, far in self._steps:
                other = index + step
                if clear[other] < self._clear or clear[index] + clear[other] < far:
                    continue  # a coarse grid does not show walls between its points
                if length + far < rest[other] and not (guarded[index] and self._is_barred(index, other)):
                    rest[other], self._next[other] = length + far, index
                    heappush(open_, (length + far + self._least(other), other))
        return rest[wanted]

    def _least(self, index: int) -> float:
        """Least length of a path over the grid from a point to where the search was begun, m."""
        row, column = divmod(index, self._map.width)
        down, aside = abs(row - self._focus[0]), abs(column - self._focus[1])
        return self._map.step * (max(down, aside) + (math.sqrt(2.0) - 1.0) * min(down, aside))

    def _follow(self, index: int) -> list[int]:
        way = [index]
        while self._next[way[-1]] >= 0:
            way.append(self._next[way[-1]])
        return way

    def _advance(self, position: Vector) -> None:
        """Head for the farthest visible point of the path, found with doubling strides."""
        stride, last = 1, len(self._way) - 1
        while self._sent < last and stride:
            to = min(self._sent + stride, last)
            if self._sees(position, self._map.place(self._way[to])):
                self._sent, stride = to, 2 * stride
            else:
                stride //= 4
        here = self._map.place(self._way[self._sent])
        if self._sent < last and math.dist(position, here) < 0.5 * self._map.step:
            self._sent += 1  # clearance may be smaller between two grid points


def _sides(shapes: Sequence[Shape]) -> tuple[Complexes, Complexes]:
    """Both ends of all sides of polygons, as complex numbers x + iy."""
    points = [shape.points for shape in shapes if isinstance(shape, ConvexPolygon)]
    ends = [
        (complex(*a), complex(*b)) for each in points for a, b in zip(each, (*each[1:], each[0]), strict=True)
    ]
    one, other = np.array(ends, dtype=np.complex128).reshape(-1, 2).T
    return one, other


def distances(shape: Shape, x: Reals, y: Reals) -> Reals:
    """Distances of points from a shape, m; negative inside."""
    if isinstance(shape, Disk):
        distance: Reals = np.hypot(x - shape.x, y - shape.y) - shape.radius
        return distance
    return _from_polygon(shape, x, y)


def _from_polygon(shape: ConvexPolygon, x: Reals, y: Reals) -> Reals:
    x, y = np.broadcast_arrays(x, y)
    inside, outside = np.full_like(x, -np.inf), np.full_like(x, np.inf)
    for (nx, ny, offset), (ax, ay), (bx, by) in zip(
        shape.sides, shape.points, (*shape.points[1:], shape.points[0]), strict=True
    ):
        np.maximum(inside, nx * x + ny * y - offset, out=inside)
        ux, uy = bx - ax, by - ay
        part = np.clip(((x - ax) * ux + (y - ay) * uy) / (ux * ux + uy * uy), 0.0, 1.0)
        np.minimum(outside, np.hypot(x - ax - part * ux, y - ay - part * uy), out=outside)
    found: Reals = np.where(inside <= 0.0, inside, outside)
    return found
