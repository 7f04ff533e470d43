"""Conversion of an occupancy grid to convex obstacles that cover it, within a stated error.

Every piece is the convex hull of cells, so pieces cover all cells they are made of. A piece is accepted if it
overlaps no cell farther than the error from all solid ones; then every point of an obstacle is within the
error of a solid cell. Sets of cells whose hull is not accepted are split, and neighbours are joined again if
accepted. Solid cells are those that no robot can enter.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Final, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from deploy.maps.occupancy import Mask, Occupancy
from protocol.arrays import Reals
from protocol.scenario.model import Position

_AROUND: Final = np.ones((3, 3), dtype=bool)
_CUTS: Final = (0.25, 0.5, 0.75)  # quantiles at which a set may be split along each axis
_MANY: Final = 500  # cells; a larger set is halved without comparing cuts
_MOST_CORNERS: Final = 64  # of a polygon in a scenario
Ints = NDArray[np.intp]
_Corner = tuple[int, int]
_Point = TypeVar("_Point", _Corner, Position)


class PlanOfPieces(NamedTuple):
    """A map for robots."""

    workspace: tuple[Position, ...]  # corners of the rectangle around the free space they fit into, m
    obstacles: list[tuple[Position, ...]]  # in it, convex: corners, m
    free: Mask  # cells of that free space


def floor_plan(
    grid: Occupancy,
    error: float,
    radius: float = 0.0,
    *,
    unknown_is_free: bool = False,
    rim: bool = False,
) -> PlanOfPieces:
    """Obstacles that cover all cells that are not free, and reach at most `error` (m) into free ones.

    Args:
        radius: of the smallest robot, m; free space too narrow for it everywhere is left out.
        unknown_is_free: whether robots may enter unknown cells.
        rim: whether obstacles also cover the cells around the workspace, for a larger workspace.
    """
    solid = grid.occupied if unknown_is_free else grid.occupied | grid.unknown
    free = _roomy(~solid, radius / grid.resolution)
    if not free.any():
        return PlanOfPieces((), [], free)
    rows, columns = (np.flatnonzero(free.any(axis=axis)) for axis in (1, 0))
    bottom, top, left, right = int(rows[0]), int(rows[-1]) + 1, int(columns[0]), int(columns[-1]) + 1
    inside = np.pad(free[bottom:top, left:right], int(rim))
    allowed = _near(~inside, error / grid.resolution)
    pieces = [
        tuple(grid.place(left + column - rim, bottom + row - rim) for column, row in piece)
        for piece in _pieces(~inside, _Forbidden(allowed))
    ]
    around = ((left, bottom), (right, bottom), (right, top), (left, top))
    return PlanOfPieces(tuple(grid.place(*corner) for corner in around), pieces, free)


def _roomy(free: Mask, radius: float) -> Mask:
    """The connected parts of free space that hold a disk of `radius` (cells)."""
    count_of, _ = ndimage.label(free)
    room = np.asarray(ndimage.distance_transform_edt(np.pad(free, 1)))[1:-1, 1:-1]
    kept = np.unique(count_of[free & (room >= radius)])
    return np.isin(count_of, kept[kept > 0])


def _near(solid: Mask, error: float) -> Mask:
    """Cells within `error` (cells) of a solid cell, measured between centres."""
    if not solid.any():
        return solid
    distances = np.asarray(ndimage.distance_transform_edt(~solid))
    near: Mask = distances <= error
    return near


class _Forbidden:
    """Counts the cells of a convex polygon that no obstacle may overlap."""

    def __init__(self, allowed: Mask) -> None:
        self._before = np.zeros((allowed.shape[0], allowed.shape[1] + 1), dtype=np.intp)
        np.cumsum(~allowed, axis=1, out=self._before[:, 1:])

    def inside(self, hull: list[_Corner]) -> int:
        """Corners are (column, row), counterclockwise from the lowest, then leftmost one."""
        top = max(range(len(hull)), key=lambda n: (hull[n][1], hull[n][0]))
        right, left = np.array(hull[: top + 1]), np.array([hull[0], *hull[: top - 1 : -1]])
        rows = np.arange(hull[0][1], hull[top][1] + 1)
        low = _outermost(rows, left, np.minimum)
        high = _outermost(rows, right, np.maximum)
        low, high = np.minimum(low[:-1], low[1:]), np.maximum(high[:-1], high[1:])
        begin, end = np.floor(low + 1e-9).astype(np.intp), np.ceil(high - 1e-9).astype(np.intp)
        each = rows[:-1]
        return int((self._before[each, end] - self._before[each, begin]).sum())


def _outermost(rows: Ints, chain: Ints, pick: np.ufunc) -> Reals:
    """Column of an ascending chain of corners in each row; the outer end of a level side."""
    flat = np.interp(rows, chain[:, 1], chain[:, 0])
    pick.at(flat, chain[:, 1] - rows[0], chain[:, 0].astype(np.float64))
    return flat


class _Piece(NamedTuple):
    """A convex polygon, and the number of forbidden cells that it overlaps."""

    hull: list[_Corner]
    bad: int


def _pieces(cells: Mask, forbidden: _Forbidden) -> list[list[_Corner]]:
    """Corners (column, row) of convex pieces that together cover all `cells`."""
    numbered, _ = ndimage.label(cells, _AROUND)
    found: list[_Piece] = []
    for number, box in enumerate(ndimage.find_objects(numbered), 1):
        rows, columns = np.nonzero(numbered[box] == number)
        found += _joined(list(_split(rows + box[0].start, columns + box[1].start, forbidden)), forbidden)
    return [each.hull for each in _joined(found, forbidden)]


def _piece(points: list[_Corner], forbidden: _Forbidden) -> _Piece:
    corners = hull(points)
    return _Piece(corners, forbidden.inside(corners) + (len(corners) > _MOST_CORNERS))


def _around(rows: Ints, columns: Ints, forbidden: _Forbidden) -> _Piece:
    base = rows.min()
    left = np.full(rows.max() - base + 2, np.iinfo(np.intp).max)  # of the corners at each height
    right = np.full(len(left), -1)
    for height in (rows - base, rows - base + 1):
        np.minimum.at(left, height, columns)
        np.maximum.at(right, height, columns + 1)
    (each,) = np.nonzero(right >= 0)
    heights = (each + base).tolist()
    return _piece(
        [*zip(left[each].tolist(), heights, strict=True), *zip(right[each].tolist(), heights, strict=True)],
        forbidden,
    )


def _split(rows: Ints, columns: Ints, forbidden: _Forbidden) -> Iterator[_Piece]:
    """Accepted hulls of parts of a set of cells, cut repeatedly where the fewest forbidden cells remain."""
    waiting = [(rows, columns, _around(rows, columns, forbidden))]
    while waiting:
        rows, columns, whole = waiting.pop()
        if not whole.bad:
            yield whole
            continue
        waiting += _best_cut(rows, columns, forbidden)


def _best_cut(rows: Ints, columns: Ints, forbidden: _Forbidden) -> list[tuple[Ints, Ints, _Piece]]:
    best: list[tuple[Ints, Ints, _Piece]] = []
    least = math.inf
    for along in (rows, columns) if len(rows) <= _MANY else (max(rows, columns, key=np.ptp),):
        for low in _cuts(along):
            parts, bad = [], 0
            for side in (low, ~low):
                if bad < least:  # else the other side need not be known
                    piece = _around(rows[side], columns[side], forbidden)
                    parts.append((rows[side], columns[side], piece))
                    bad += piece.bad
            if bad < least:
                best, least = parts, bad
    return best


def _cuts(along: Ints) -> Iterator[Mask]:
    middle = (int(along.min()) + int(along.max())) // 2
    others = np.quantile(along, _CUTS).astype(np.intp).tolist() if len(along) <= _MANY else []
    for place in sorted({middle, *others}):
        low: Mask = along <= place
        if not low.all():
            yield low


def _joined(pieces: list[_Piece], forbidden: _Forbidden) -> list[_Piece]:
    pieces, there = list(pieces), np.ones(len(pieces), dtype=bool)
    low = np.array([np.min(each.hull, axis=0) for each in pieces])
    high = np.array([np.max(each.hull, axis=0) for each in pieces])
    for index in range(len(pieces)):
        grows = bool(there[index])
        while grows:
            grows = False
            near = there & (low <= high[index]).all(axis=1) & (high >= low[index]).all(axis=1)
            near[index] = False
            for other in np.flatnonzero(near).tolist():
                both = _piece(pieces[index].hull + pieces[other].hull, forbidden)
                if not both.bad:
                    pieces[index], there[other], grows = both, False, True
                    low[index], high[index] = np.min(both.hull, axis=0), np.max(both.hull, axis=0)
    return [pieces[index] for index in np.flatnonzero(there).tolist()]


def hull(points: Iterable[_Point]) -> list[_Point]:
    """Corners of the convex hull, counterclockwise from the lowest, then leftmost (Andrew 1979)."""
    upwards = sorted(set(points), key=lambda point: (point[1], point[0]))
    return _chain(upwards)[:-1] + _chain(upwards[::-1])[:-1]


def _chain(points: list[_Point]) -> list[_Point]:
    """Points of a sequence at which its right-hand hull turns left."""
    chain: list[_Point] = []
    for x, y in points:
        while len(chain) > 1:
            (ax, ay), (bx, by) = chain[-2:]
            if (bx - ax) * (y - by) - (by - ay) * (x - bx) > 0:
                break
            chain.pop()
        chain.append((x, y))
    return chain
