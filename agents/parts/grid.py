"""The layout of a room, and a grid of it: free cells for a disk, distance fields, reachable cells.

`Reach` represents a set of cells by an integer with a bit for each, so that a step of a flood takes a few
shifts of the whole grid: the search for orders needs reachability far more often than distance.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from agents.law.distance_field import distances
from protocol.arrays import Reals
from protocol.geometry import Disk, Shape
from protocol.messages import Vector
from protocol.scenario.model import Part, Scenario

Cells = NDArray[np.bool_]

_SAG: Final = 1.0 / 16.0  # cells of room for straight lines between free cells
_KEPT: Final = 1024  # cached sets
_STEPS: Final = ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1))
_AROUND: Final = tuple((i, j) for i in range(-2, 3) for j in range(-2, 3))  # may replace a point's own cell


class Grid:
    """Cells of a room, of `size` m."""

    def __init__(self, room: Shape, size: float) -> None:
        (left, low), (right, high) = room.box
        self.size = size
        self._left, self._low = left, low
        self.x, self.y = np.meshgrid(
            np.arange(left, right + size, size), np.arange(low, high + size, size), indexing="ij"
        )
        self._depth = -distances(room, self.x, self.y)

    def clear(self, shapes: Iterable[Shape], radius: float) -> Cells:
        """Cells in which a disk of `radius` (m) is inside, and overlaps none of the shapes."""
        free: Cells = self._depth >= radius + _SAG * self.size
        for shape in shapes:
            free &= ~self.blocked(shape, radius)
        return free

    def blocked(self, shape: Shape, radius: float) -> Cells:
        """Cells in which a disk of `radius` (m) overlaps a shape."""
        return np.asarray(distances(shape, self.x, self.y) < radius + _SAG * self.size)

    def cell(self, point: Vector) -> tuple[int, int]:
        """The cell of a point."""
        i = round((point[0] - self._left) / self.size)
        j = round((point[1] - self._low) / self.size)
        return min(max(i, 0), self.x.shape[0] - 1), min(max(j, 0), self.x.shape[1] - 1)

    def distance_field(self, free: Cells, begin: Sequence[Vector]) -> Reals:
        """Shortest distance through free cells from these points to every cell, m; infinite without path."""
        far = np.full(free.shape, np.inf)
        for point in begin:
            cell = self._near(free, point)
            if cell is not None:
                far[cell] = 0.0
        wide, wall = np.pad(far, 1, constant_values=np.inf), np.where(free, 0.0, np.inf)
        inner, diagonal = wide[1:-1, 1:-1], self.size * math.sqrt(2.0)
        while True:  # until no distance decreases
            before = inner.copy()
            aside = np.minimum(wide[:, :-2], wide[:, 2:])
            straight = np.minimum(aside[1:-1], np.minimum(wide[:-2, 1:-1], wide[2:, 1:-1])) + self.size
            oblique = np.minimum(aside[:-2], aside[2:]) + diagonal
            np.minimum(inner, np.minimum(straight, oblique) + wall, out=inner)
            if (before == inner).all():
                return inner

    def lengths(self, far: Reals, points: Sequence[Vector]) -> Reals:
        """Lengths of such paths to points, m; the cells of the points need not be free."""
        x, y = np.array(points, dtype=float).reshape(-1, 2).T
        i = np.clip(np.rint((x - self._left) / self.size).astype(int), 0, far.shape[0] - 1)
        j = np.clip(np.rint((y - self._low) / self.size).astype(int), 0, far.shape[1] - 1)
        x, y = self.x[i, j] - x, self.y[i, j] - y
        wide = np.pad(far, 1, constant_values=np.inf)
        ways = [
            wide[i + 1 + dx, j + 1 + dy] + np.hypot(x + dx * self.size, y + dy * self.size)
            for dx in (-1, 0, 1)
            for dy in (-1, 0, 1)
        ]
        return np.asarray(np.minimum.reduce(ways))

    def path(self, far: Reals, begin: Vector) -> list[Vector]:
        """Cells of such a path, from a point to its beginning, m; empty if there is none."""
        cell = self._near(np.isfinite(far), begin)
        if cell is None:
            return []
        points = []
        while True:
            points.append((float(self.x[cell]), float(self.y[cell])))
            if far[cell] == 0.0:
                return points
            cell = min(self._beside(cell, _STEPS), key=lambda each: (far[each], each))

    def sees(self, free: Cells, one: Vector, other: Vector) -> bool:
        """Whether all cells on the straight line between two points are free, except near the ends."""
        length = math.dist(one, other)
        count = max(1, math.ceil(length / self.size))
        for number in range(2, count - 1):
            part = number / count
            point = one[0] + part * (other[0] - one[0]), one[1] + part * (other[1] - one[1])
            if not free[self.cell(point)]:
                return False
        return True

    def near(self, point: Vector, is_free: Callable[[int, int], bool]) -> tuple[int, int] | None:
        """The cell of a point, or the nearest free one not far from it."""
        i, j = self.cell(point)
        if is_free(i, j):
            return i, j
        near = [cell for cell in self._beside((i, j), _AROUND) if is_free(*cell)]
        return min(near, key=lambda c: (math.dist((self.x[c], self.y[c]), point), c), default=None)

    def _near(self, free: Cells, point: Vector) -> tuple[int, int] | None:
        return self.near(point, lambda i, j: bool(free[i, j]))

    def _beside(self, cell: tuple[int, int], steps: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
        shape = self.x.shape
        around = [(cell[0] + dx, cell[1] + dy) for dx, dy in steps]
        return [(i, j) for i, j in around if 0 <= i < shape[0] and 0 <= j < shape[1]]


class Reach:
    """Reachability on a grid, with cells as bits of an integer."""

    def __init__(self, grid: Grid) -> None:
        self._grid = grid
        self._row: int = grid.x.shape[1] + 1  # a blocked cell after each row, so that no shift wraps around
        self._inside: dict[float, int] = {}
        self._taken: dict[tuple[Shape, float], int] = {}

    def clear(self, shapes: Iterable[Shape], radius: float) -> int:
        """Cells in which a disk of `radius` (m) is inside, and overlaps none of the shapes."""
        inside = self._inside.get(radius)
        if inside is None:
            inside = self._inside[radius] = self._bits(self._grid.clear((), radius))
        taken = 0
        for shape in shapes:
            taken |= self._blocked(shape, radius)
        return inside & ~taken

    def spread(self, free: int, begin: Iterable[Vector]) -> int:
        """Cells reachable through free cells from any of some points."""
        reached = 0
        for point in begin:
            reached |= self._near(free, point)
        return self._flood(free, reached)

    def widest(self, free: int, cells: int) -> int:
        """The largest connected region of free cells that contains some of these cells."""
        left, best = cells & free, 0
        while left:
            found = self._flood(free, left & -left)
            left &= ~found
            best = max(best, found, key=int.bit_count)
        return best

    def _flood(self, free: int, reached: int) -> int:
        row = self._row
        while True:
            wide = reached | reached << 1 | reached >> 1
            more = (wide | wide << row | wide >> row) & free
            if more == reached:
                return reached
            reached = more

    def among(self, reached: int, points: Iterable[Vector]) -> list[Vector]:
        """Points with a reachable cell, their own or one beside it."""
        row = self._row
        wide = reached | reached << 1 | reached >> 1
        wide |= wide << row | wide >> row
        return [point for point in points if self._has(wide, *self._grid.cell(point))]

    def _blocked(self, shape: Shape, radius: float) -> int:
        key = shape, radius
        found = self._taken.get(key)
        if found is None:
            if len(self._taken) >= _KEPT:
                self._taken.clear()
            found = self._taken[key] = self._bits(self._grid.blocked(shape, radius))
        return found

    def _bits(self, cells: Cells) -> int:
        rows = np.pad(cells, ((0, 0), (0, 1)))
        return int.from_bytes(np.packbits(rows, axis=None, bitorder="little").tobytes(), "little")

    def _near(self, free: int, point: Vector) -> int:
        """The cell of a point, or the nearest free one not far from it; 0 if there is none."""
        cell = self._grid.near(point, lambda i, j: self._has(free, i, j))
        return 0 if cell is None else 1 << (cell[0] * self._row + cell[1])

    def _has(self, cells: int, i: int, j: int) -> bool:
        return cells >> (i * self._row + j) & 1 == 1


_Kept = TypeVar("_Kept")

DIRECTIONS: Final = 64  # of approaches to a part
GAPS: Final = (0.5, 0.15, 0.85)  # between a robot and a part, over the reach
MARGIN: Final = 0.1  # clearance of a place from all other obstacles, over the reach
_HOME: Final = 1e-9  # m


@dataclass(frozen=True)
class Layout:
    """Static obstacles and parts; layouts are equal if these are."""

    parts: Mapping[int, Vector]  # positions, m; that of a part on a static robot is the robot's
    others: tuple[Shape, ...] = ()  # obstacles that are not parts, and static robots without their parts
    held: Mapping[int, float] = field(default_factory=dict)  # radius of a static robot with its part, by part
    promised: Mapping[int, Vector] = field(default_factory=dict, compare=False)  # of parts claimed or carried
    robots: tuple[Vector, ...] = field(default=(), compare=False)  # positions of live peers, m

    @property
    def settled(self) -> Layout:
        """The layout after all parts carried or claimed are delivered."""
        return replace(self, parts={**self.parts, **self.promised}, held=_without(self.held, *self.promised))

    def moved(self, part: int, to: Vector) -> Layout:
        """The layout with a part at another position, m."""
        return replace(self, parts={**self.parts, part: to}, held=_without(self.held, part))

    def without(self, part: int) -> Layout:
        """The layout without a part, as after it is taken up."""
        return replace(self, parts=_without(self.parts, part), held=_without(self.held, part))


class GridPlaces:
    """Places to take parts up and to put them down, for robots of one radius, m, without a part."""

    def __init__(self, scenario: Scenario, radius: float, grid: Grid) -> None:
        self.parts: dict[int, Part] = dict(enumerate(scenario.parts, 1))
        self.radius, self.reach = radius, scenario.carrying.reach
        self._room, self._grid = scenario.workspace.shape, grid
        turns = np.arange(DIRECTIONS) * (math.tau / DIRECTIONS)
        self._cos, self._sin = np.cos(turns), np.sin(turns)

    def loaded(self, part: int) -> float:
        """Radius of the disk of a robot with a part, m."""
        return max(self.radius, self.parts[part].radius)

    def size(self, part: int, layout: Layout) -> float:
        """Radius of the disk of a part in a layout, m."""
        return layout.held.get(part, self.parts[part].radius)

    def standing(self, layout: Layout) -> list[Shape]:
        """Shapes of all obstacles and parts of a layout."""
        disks = [Disk(*at, self.size(part, layout)) for part, at in layout.parts.items()]
        return [*layout.others, *disks]

    def is_home(self, part: int, layout: Layout) -> bool:
        """Whether a part is at its goal."""
        return math.dist(layout.parts[part], self.parts[part].goal) < _HOME

    def is_barred(self, part: int, layout: Layout) -> bool:
        """Whether an obstacle that is not a part covers a part's goal."""
        spec = self.parts[part]
        return any(shape.distance(*spec.goal) < spec.radius for shape in layout.others)

    def to_take(self, part: int, layout: Layout) -> list[Vector]:
        """Places at which a robot can take a part up, and has room for the larger disk, m.

        A part on a static robot remains there until a robot requests it whose larger disk is clear of both.
        """
        grown = self.loaded(part) - self.radius if part in layout.held else 0.0
        rest = self.standing(layout.without(part))
        return self._around(
            layout.parts[part], self.radius + self.size(part, layout), grown, self.loaded(part), rest
        )

    def to_put(self, part: int, target: Vector, layout: Layout) -> list[Vector]:
        """Places at which a carrier can put a part down at a target, m; none if the target is covered."""
        radius, loaded, rest = self.parts[part].radius, self.loaded(part), self.standing(layout)
        if any(shape.distance(*target) < radius for shape in rest):
            return []
        return self._around(target, loaded + radius, 0.0, loaded, rest)

    def _around(
        self, centre: Vector, touching: float, least: float, radius: float, rest: list[Shape]
    ) -> list[Vector]:
        """Places at a gap from `least` to the reach at which a disk of `radius` is clear of the rest, m."""
        spread = self.reach - least
        if spread <= 0.0:
            return []
        gaps = np.array([touching + least + part * spread for part in GAPS])
        x = (centre[0] + np.outer(gaps, self._cos)).ravel()
        y = (centre[1] + np.outer(gaps, self._sin)).ravel()
        room = radius + MARGIN * self.reach
        clear = -distances(self._room, x, y) >= room
        near = float(gaps.max()) + room
        for shape in rest:
            if shape.distance(*centre) < near:
                clear &= distances(shape, x, y) >= room
        return [(float(x[n]), float(y[n])) for n in clear.nonzero()[0]]


def _without(kept: Mapping[int, _Kept], *parts: int) -> dict[int, _Kept]:
    return {each: what for each, what in kept.items() if each not in parts}
