"""Which cells the centre of a disk can get to.

A set of cells is an integer with a bit for each, so that a flood takes a few shifts of the whole floor at a
step: whether there is a way is asked far more often than how long it is.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Final

import numpy as np

from agents.movers.floor import Cells, Grid
from protocol.geometry import Shape
from protocol.messages import Vector

NEAR: Final = 2  # cells around a point that stand for its own where that is not free
_KEPT: Final = 1024  # sets that are remembered


class Reach:
    """Ways on a grid, as sets of cells."""

    def __init__(self, grid: Grid) -> None:
        self._grid = grid
        self._columns = grid.x.shape[1]
        self._row = self._columns + 1  # a cell behind each row is never free, so that no shift wraps around
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
        """All that can be got to through free cells from some points."""
        reached = 0
        for point in begin:
            reached |= self._near(free, point)
        return self._flood(free, reached)

    def widest(self, free: int, cells: int) -> int:
        """What can be got to from some of the cells, those from where it is most."""
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
        """Points of which the own cell, or one beside it, can be got to."""
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
        i, j = self._grid.cell(point)
        if self._has(free, i, j):
            return self._bit(i, j)
        around = range(-NEAR, NEAR + 1)
        near = [(i + dx, j + dy) for dx in around for dy in around if self._has(free, i + dx, j + dy)]
        x, y = self._grid.x, self._grid.y
        cell = min(near, key=lambda c: (math.dist((x[c], y[c]), point), c), default=None)
        return 0 if cell is None else self._bit(*cell)

    def _bit(self, i: int, j: int) -> int:
        return int(1 << (i * self._row + j))

    def _has(self, cells: int, i: int, j: int) -> bool:
        return i >= 0 and 0 <= j < self._columns and cells >> (i * self._row + j) & 1 == 1
