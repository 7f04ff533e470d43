"""Clearance: gaps between disks, boundary and obstacles, over continuous time.

Positions are complex numbers x + iy, m, shape (..., p), in the order of robot ids, for any number of ticks at
once. Gaps, shape (..., q + p + c), are those of the q pairs i < j, then of each robot to the boundary, then
of the c pairs of a robot and one of m obstacles; negative is overlap. During straight motion at constant
speed the distance from a convex set is a convex function of time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from copy import copy
from typing import Final

import numpy as np
from numpy.typing import NDArray

from protocol.arrays import Complexes, Reals
from protocol.geometry import ConvexPolygon, Disk, Shape
from protocol.scenario.model import Scenario

Indices = NDArray[np.intp]
TimeSpan = tuple[float, float]

REACH: Final = 12.0  # mean radii
FEW: Final = 1 << 14  # number of pairs up to which all are measured
_SOME: Final = 500  # polygons at once, limited by the cache
_ROUNDING: Final = 1e-6  # of the reach
_TINY: Final = np.finfo(np.float64).tiny
_THIRDS: Final = 80  # bisections of an interval, down to the resolution of a double


class Disks:
    """A fleet's disks (`radii` by robot id, m), with boundary and obstacles, by number. Immutable."""

    def __init__(self, radii: Mapping[int, float], room: Shape, obstacles: Mapping[int, Shape]) -> None:
        self.ids = tuple(sorted(radii))  # robot ids in increasing order, p of them
        self.radii: Reals = np.array([radii[robot] for robot in self.ids])  # in that order, m
        self.first, self.second = np.triu_indices(len(self.ids), 1)  # index of either robot of each pair
        # Distance at which each pair touches, rho_ij, m.
        self.contact: Reals = self.radii[self.first] + self.radii[self.second]
        self.room = room
        # Distance from the origin at which each robot touches the boundary of a round room, rho_0i, m.
        self.wall: Reals = (room.radius if isinstance(room, Disk) else np.inf) - self.radii
        self.numbers, self.shapes = tuple(obstacles), tuple(obstacles.values())  # in the same order
        # Index of either of each pair of a robot and an obstacle.
        self.obstacle, self.robot = np.divmod(np.arange(len(self.shapes) * len(self.ids)), len(self.ids))
        around = [shape.around for shape in self.shapes]
        # Centres and radii of the disks around these, m.
        self.centres: Complexes = np.array([complex(each.x, each.y) for each in around], dtype=np.complex128)
        self.sizes: Reals = np.array([each.radius for each in around])
        self._is_round = np.array([isinstance(shape, Disk) for shape in self.shapes], dtype=np.bool_)
        polygons = [shape for shape in self.shapes if isinstance(shape, ConvexPolygon)]
        self._polygon = np.cumsum(~self._is_round) - 1  # index among polygons
        self._corners, self._sides = _padded(polygons), _sides(polygons)

    @classmethod
    def of(cls, scenario: Scenario, obstacles: Mapping[int, Shape] | None = None) -> Disks:
        """The disks of a scenario, among its obstacles or others."""
        radii = {spec.id: spec.radius for spec in scenario.robots}
        return cls(radii, scenario.workspace.shape, scenario.shapes if obstacles is None else obstacles)

    def among(self, obstacles: Mapping[int, Shape]) -> Disks:
        """The same disks among other obstacles."""
        return Disks(dict(zip(self.ids, self.radii.tolist(), strict=True)), self.room, obstacles)

    def near(self, places: Complexes, reach: float) -> Disks:
        """The same disks, with only those pairs whose gap may be at most `reach` (m) at places, (p,)."""
        few = copy(self)
        few.first, few.second = close_pairs(places, self.radii, reach)
        few.contact = self.radii[few.first] + self.radii[few.second]
        gap = np.abs(places - self.centres[:, None]) - self.sizes[:, None] - self.radii
        few.obstacle, few.robot = np.nonzero(gap <= reach)
        return few

    def __len__(self) -> int:
        return len(self.contact) + len(self.ids) + len(self.robot)

    def relative(self, positions: Complexes) -> Complexes:
        """Relative position d_ij = b_i - b_j of each pair, shape (..., q)."""
        relative: Complexes = positions[..., self.first] - positions[..., self.second]
        return relative

    def names(self, index: int) -> tuple[int, int]:
        """Ids of both ends of a gap; 0 is the boundary, -n is obstacle n."""
        pairs = len(self.contact)
        if index < pairs:
            return (self.ids[self.first[index]], self.ids[self.second[index]])
        index -= pairs
        if index < len(self.ids):
            return (0, self.ids[index])
        index -= len(self.ids)
        return (-self.numbers[self.obstacle[index]], self.ids[self.robot[index]])

    def beta(self, positions: Complexes) -> Reals:
        """beta of every robot with the boundary (each straight wall) and each obstacle, (n, ...) m^2.
        For a disk |b - c|^2 - (rho + r)^2, for another shape d^2 - rho^2 at a distance d.
        """
        if isinstance(self.room, Disk):
            walls = self.wall**2 - positions.real**2 - positions.imag**2
        else:
            rooms = [offset - _along(nx, ny, positions) for nx, ny, offset in self.room.sides]
            walls = np.concatenate([_squared_gap(room, self.radii) for room in rooms], axis=-1)
        offsets = positions[..., None, :] - self.centres[self._is_round, None]
        contact = self.radii + self.sizes[self._is_round, None]
        disks = offsets.real**2 + offsets.imag**2 - contact**2
        polygons = _squared_distances(self._sides, positions) - self.radii**2
        among = [each.reshape(*positions.shape[:-1], -1) for each in (disks, polygons)]
        return np.concatenate((walls, *among), axis=-1)

    def overlaps(self, index: int, before: Complexes, after: Complexes, touch: float) -> list[TimeSpan]:
        """Interval within [0, 1] of a straight motion in which a gap is below -touch."""
        pairs = len(self.contact)
        if index < pairs:
            i, j = self.first[index], self.second[index]
            start, motion = before[i] - before[j], after[i] - after[j] - (before[i] - before[j])
            return sublevel(lambda time: abs(start + time * motion), self.contact[index] - touch)
        index -= pairs
        obstacle = index >= len(self.ids)
        robot = self.robot[index - len(self.ids)] if obstacle else index
        shape = self.shapes[self.obstacle[index - len(self.ids)]] if obstacle else self.room

        def distance(time: float) -> float:
            place = before[robot] + time * (after[robot] - before[robot])
            return shape.distance(place.real, place.imag)

        radius = float(self.radii[robot])
        if obstacle:
            return sublevel(distance, radius - touch)
        inside = sublevel(distance, touch - radius) or [(1.0, 1.0)]
        outside = [(0.0, inside[0][0]), (inside[0][1], 1.0)]
        return [part for part in outside if part[0] < part[1]]

    def to_surroundings(self, before: Complexes, after: Complexes) -> Reals:
        """Smallest gaps to the boundary and to obstacles during motions, (n, p) each: (n, p + c) m."""
        if isinstance(self.room, Disk):
            walls = self.wall - np.maximum(np.abs(before), np.abs(after))
        else:
            rooms = [
                offset - np.maximum(_along(nx, ny, before), _along(nx, ny, after))
                for nx, ny, offset in self.room.sides
            ]
            walls = np.min(rooms, axis=0) - self.radii
        return np.concatenate((walls, self._to_obstacles(before, after)), axis=-1)

    def _to_obstacles(self, before: Complexes, after: Complexes) -> Reals:
        begin, end = before[..., self.robot], after[..., self.robot]
        found, is_round = np.empty(begin.shape), self._is_round[self.obstacle]
        disks, polygons = self.obstacle[is_round], self.obstacle[~is_round]
        start, motion = begin[..., is_round], end[..., is_round] - begin[..., is_round]
        found[..., is_round] = closest(start - self.centres[disks], motion) - self.sizes[disks]
        if len(polygons):
            corners = self._corners[self._polygon[polygons]]
            found[..., ~is_round] = _from_polygons(corners, begin[..., ~is_round], end[..., ~is_round])
        return found - self.radii[self.robot]


def gaps(disks: Disks, before: Complexes, after: Complexes) -> Reals:
    """Smallest gaps during straight motion from `before` to `after`, shape (..., len(disks)), m.

    The distance of a pair is smallest where its straight relative motion is nearest to the origin.
    """
    start = disks.relative(before)
    to_others = closest(start, disks.relative(after) - start) - disks.contact
    return np.concatenate((to_others, disks.to_surroundings(before, after)), axis=-1)


class NearestGaps:
    """Measures gaps as `gaps` does, but in large fleets only those of pairs that may be nearest, or touch.

    Any other pair had a gap of more than the reach, so now of more than the reach less twice the longest
    motion since. If the smallest measured gap is below that, it is the smallest of all, and no other pair
    touches.
    """

    def __init__(self, disks: Disks) -> None:
        self._all = self._near = disks
        self._reach = REACH * float(disks.radii.mean())
        self._places: Complexes | None = None  # positions at which the near pairs were found

    def __call__(self, before: Complexes, after: Complexes) -> tuple[Disks, Reals]:
        """Gaps of n motions, (n, p) each, with the smallest and all negative ones; and the disks of these."""
        if len(self._all) <= FEW:
            return self._all, gaps(self._all, before, after)
        beyond = self._beyond(before, after)
        if beyond < 0.5 * self._reach:
            self._places = before[0].copy()
            self._near = self._all.near(self._places, self._reach)
            beyond = self._beyond(before, after)
        found = gaps(self._near, before, after)
        if beyond >= 0.0 and (found.min(axis=-1) <= beyond).all():
            return self._near, found
        return self._all, gaps(self._all, before, after)

    def _beyond(self, before: Complexes, after: Complexes) -> float:
        """Lower bound of the gaps of all other pairs, m."""
        if self._places is None:
            return -np.inf
        moved = max(float(np.abs(plane - self._places).max()) for plane in (before, after))
        return (1.0 - _ROUNDING) * self._reach - 2.0 * moved


def closest(start: Complexes, motion: Complexes) -> Reals:
    """Smallest distance from the origin on the segment from `start` to `start + motion`."""
    squared = motion.real**2 + motion.imag**2
    along = start.real * motion.real + start.imag * motion.imag
    nearest = np.clip(-along / np.maximum(squared, _TINY), 0.0, 1.0)
    return np.abs(start + nearest * motion)


def lowest(convex: Callable[[float], float]) -> float:
    """Minimiser of a convex function in [0, 1]."""
    low, high = 0.0, 1.0
    for _ in range(_THIRDS):
        third = (high - low) / 3.0
        if convex(low + third) < convex(high - third):
            high -= third
        else:
            low += third
    return min((0.0, low, 1.0), key=convex)


def sublevel(convex: Callable[[float], float], level: float) -> list[TimeSpan]:
    """The part of [0, 1] in which a convex function is at most `level`, if there is one."""
    inside = lowest(convex)
    if convex(inside) > level:
        return []
    return [(_edge(convex, level, inside, 0.0), _edge(convex, level, inside, 1.0))]


def _edge(convex: Callable[[float], float], level: float, inside: float, outside: float) -> float:
    """Time between one inside and an end of the interval at which the level is crossed; otherwise the end."""
    if convex(outside) <= level:
        return outside
    for _ in range(_THIRDS):
        middle = 0.5 * (inside + outside)
        if convex(middle) <= level:
            inside = middle
        else:
            outside = middle
    return inside


def _along(nx: float, ny: float, positions: Complexes) -> Reals:
    product: Reals = nx * positions.real + ny * positions.imag
    return product


def _squared_gap(distances: Reals, contact: Reals) -> Reals:
    """distance^2 - contact^2; -contact^2 where the distance is negative."""
    return np.maximum(distances, 0.0) ** 2 - contact**2


def _padded(polygons: list[ConvexPolygon]) -> Complexes:
    """Corners of all, (m, K); shorter lists repeat their last one."""
    most = max((len(polygon.points) for polygon in polygons), default=0)
    rows = [[complex(*point) for point in polygon.points] for polygon in polygons]
    return np.array([row + row[-1:] * (most - len(row)) for row in rows], dtype=np.complex128)


def _sides(polygons: list[ConvexPolygon]) -> tuple[Reals, Reals]:
    """Matrix from (x, y, 1) to a point's distance beyond each side and its position along it from the middle,
    (2, K, m, 3); and half the lengths, (K, m, 1) m. A polygon with fewer sides repeats its last one.
    """
    most = max((len(polygon.sides) for polygon in polygons), default=0)
    rows, halves = np.empty((2, most, len(polygons), 3)), np.empty((most, len(polygons), 1))
    for index, polygon in enumerate(polygons):
        for side in range(most):
            number = min(side, len(polygon.sides) - 1)
            nx, ny, offset = polygon.sides[number]
            one, other = (nx * y - ny * x for x, y in (polygon.points * 2)[number : number + 2])
            rows[:, side, index] = (nx, ny, -offset), (-ny, nx, -0.5 * (one + other))
            halves[side, index] = 0.5 * abs(other - one)
    return rows, halves


def _squared_distances(sides: tuple[Reals, Reals], positions: Complexes) -> Reals:
    """Squared distance of points (n, p) from polygons, (n, m, p) m^2; 0 inside."""
    points = np.stack((positions.real, positions.imag, np.ones(positions.shape)), axis=-2)[..., None, :, :]
    rows, halves = sides
    found = np.empty((*positions.shape[:-1], halves.shape[1], positions.shape[-1]))
    for begin in range(0, halves.shape[1], _SOME):
        part = slice(begin, begin + _SOME)
        beyond, past = rows[0, :, part] @ points, np.abs(rows[1, :, part] @ points)
        inside = beyond.max(axis=-3) <= 0.0
        past = np.maximum(past - halves[:, part], 0.0)
        found[..., part, :] = (beyond * beyond + past * past).min(axis=-3)
        found[..., part, :][inside] = 0.0
    return found


def _from_polygons(corners: Complexes, before: Complexes, after: Complexes) -> Reals:
    """Smallest distance of moving points, (n, c), from a convex polygon each, m; minus the depth inside."""
    distance: Reals
    edge = np.roll(corners, -1, axis=1) - corners  # (c, K)
    begin, end = before[..., None], after[..., None]  # (n, c, 1)
    distance = np.minimum(closest(begin - corners, end - begin), closest(corners - begin, edge))
    distance = np.minimum(distance, closest(corners - end, edge)).min(axis=-1)
    lengths = np.abs(edge)
    normals = np.where(lengths > 0.0, -1j * edge / np.maximum(lengths, _TINY), 0.0)
    first = ((begin - corners) * normals.conj()).real  # signed distances from the sides
    slope = ((end - begin) * normals.conj()).real
    inside = _enters(np.where(lengths > 0.0, first, -np.inf), slope)
    for n, c in np.argwhere(inside):
        sides = lengths[c] > 0.0
        distance[n, c] = _deepest(first[n, c][sides], slope[n, c][sides])
    return distance


def _enters(first: Reals, slope: Reals) -> NDArray[np.bool_]:
    """Whether all of first + t slope <= 0 for some t in [0, 1], along the last axis."""
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = -first / slope
    low = np.where(slope < 0.0, crossing, np.where((slope == 0.0) & (first > 0.0), np.inf, 0.0)).max(axis=-1)
    high = np.where(slope > 0.0, crossing, 1.0).min(axis=-1)
    entered: NDArray[np.bool_] = np.maximum(low, 0.0) <= np.minimum(high, 1.0)
    return entered


def _deepest(first: Reals, slope: Reals) -> float:
    """Minimum over t in [0, 1] of the largest of first + t slope."""

    def depth(time: float) -> float:
        return float((first + time * slope).max())

    return depth(lowest(depth))


def close_pairs(places: Complexes, radii: Reals, reach: float) -> tuple[Indices, Indices]:
    """All pairs whose gap is at most `reach`: indices i < j, in the order of a triangle's rows.

    Only pairs close in x are examined: a sweep along that axis.

    Args:
        places: centres x + iy, shape (p,), m.
        radii: shape (p,), m.
        reach: m, at least 0.
    """
    order = np.argsort(places.real, kind="stable")
    x = places.real[order]
    widest = 2.0 * float(radii.max(initial=0.0)) + reach
    behind = np.arange(1, len(x) + 1)
    counts = np.maximum(np.searchsorted(x, x + widest * (1.0 + 1e-9), side="right") - behind, 0)
    one = np.repeat(np.arange(len(x)), counts)
    other = np.arange(len(one)) - np.repeat(np.cumsum(counts) - counts, counts) + behind[one]
    first, second = np.minimum(order[one], order[other]), np.maximum(order[one], order[other])
    close = np.abs(places[first] - places[second]) - (radii[first] + radii[second]) <= reach
    first, second = first[close], second[close]
    rows = np.lexsort((second, first))
    return first[rows], second[rows]
