"""How a mover gets along: by the shortest way among what stands, out of the way of whoever goes first.

Everybody reckons the others' ways by itself, from where they are and what they claim. Nothing here is needed
for safety: lines see to that.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from agents.parts.grid import Grid, Reals
from protocol.geometry import Shape
from protocol.messages import Vector

Cells = NDArray[np.bool_]

ASIDE: Final = 0.2  # of the own radius, by which to keep clear of the way of whoever goes first
AHEAD: Final = 0.5  # of the own radius, within which it would be in somebody's way
_KEPT: Final = 16  # fields of ways that are remembered


@dataclass(frozen=True)
class Traveller:
    """Somebody on the way.

    Attributes:
        at, to: where it is and where it goes, m.
        radius: of its disk, m.
        among: what stands in its way.
        leaves: what stands there once it has arrived.
    """

    at: Vector
    to: Vector
    radius: float
    among: tuple[Shape, ...]
    leaves: tuple[Shape, ...] = ()


class Traffic:
    """Ways among what stands, for one robot."""

    def __init__(self, grid: Grid) -> None:
        self._grid = grid
        self._fields: dict[tuple[Vector, float, tuple[Shape, ...]], tuple[Cells, Reals]] = {}

    def aim(self, me: Traveller, first: Sequence[Traveller]) -> Vector:
        """Where to go straight to, m: along the own way; aside from the ways of those who go first, and not
        into them.

        Args:
            first: who goes before this robot.
        """
        ways = [self._way(each) for each in first]
        if self._is_in_the_way(me.at, me, first, ways):
            aside = self._aside(me, first, ways)
            return self._ahead(me) if aside is None else aside
        aim = self._ahead(me)
        away = math.dist(me.at, aim)
        part = min(1.0, AHEAD * me.radius / max(away, 1e-9))
        soon = me.at[0] + part * (aim[0] - me.at[0]), me.at[1] + part * (aim[1] - me.at[1])
        return me.at if self._is_in_the_way(soon, me, first, ways) else aim

    def _ahead(self, me: Traveller) -> Vector:
        """The farthest point in sight on the own way."""
        free, _ = self._field(me)
        path = self._way(me)
        if len(path) < 2 or self._grid.sees(free, me.at, me.to):
            return me.to
        seen = [point for point in path[1:-1] if self._grid.sees(free, me.at, point)]
        return seen[-1] if seen else path[min(2, len(path) - 1)]

    def _way(self, traveller: Traveller) -> list[Vector]:
        return self._grid.path(self._field(traveller)[1], traveller.at)

    def _field(self, traveller: Traveller) -> tuple[Cells, Reals]:
        """Free cells, and how far it is from each to where somebody goes, m."""
        key = traveller.to, traveller.radius, traveller.among
        if key not in self._fields:
            if len(self._fields) >= _KEPT:
                del self._fields[next(iter(self._fields))]
            free = self._grid.clear(traveller.among, traveller.radius)
            self._fields[key] = free, self._grid.distance_field(free, [traveller.to])
        return self._fields[key]

    def _aside(
        self, me: Traveller, first: Sequence[Traveller], ways: Sequence[Sequence[Vector]]
    ) -> Vector | None:
        """Where to make room, m: where one is not shut in by what others leave, if there is such a place;
        None if that is nowhere."""
        free = self._grid.clear(me.among, me.radius)
        wanted = free.copy()
        for each, way in zip(first, ways, strict=True):
            away = self._away([each.at, *way, each.to])
            wanted &= away >= self._room(me, each)
            free &= self._away([each.at]) >= me.radius + each.radius
        far = self._grid.distance_field(free, [me.at])
        far[~wanted] = np.inf
        open_ = np.where(self._stays_open(me, first), far, np.inf)
        far = open_ if np.isfinite(open_).any() else far
        best = np.unravel_index(int(far.argmin()), far.shape)
        if not math.isfinite(far[best]):
            return None
        goal = float(self._grid.x[best]), float(self._grid.y[best])
        back = self._grid.path(self._grid.distance_field(free, [goal]), me.at)
        seen = [point for point in back if self._grid.sees(free, me.at, point)]
        return seen[-1] if seen else goal

    def _stays_open(self, me: Traveller, first: Sequence[Traveller]) -> Cells:
        """From which cells there is a way for the robot once others have left what they carry."""
        left = [shape for each in first for shape in each.leaves]
        return np.isfinite(
            self._grid.distance_field(self._grid.clear((*me.among, *left), me.radius), [me.to])
        )

    def _is_in_the_way(
        self, at: Vector, me: Traveller, first: Sequence[Traveller], ways: Sequence[Sequence[Vector]]
    ) -> bool:
        return any(
            self._distance(at, [each.at, *way]) < self._room(me, each)
            for each, way in zip(first, ways, strict=True)
        )

    def _room(self, me: Traveller, other: Traveller) -> float:
        return me.radius + other.radius + ASIDE * me.radius

    def _distance(self, point: Vector, way: Sequence[Vector]) -> float:
        return min(math.dist(point, each) for each in way)

    def _away(self, way: Sequence[Vector]) -> Reals:
        """How far each cell is from a way, m."""
        far = np.full(self._grid.x.shape, np.inf)
        for x, y in way:
            np.minimum(far, np.hypot(self._grid.x - x, self._grid.y - y), out=far)
        return far
