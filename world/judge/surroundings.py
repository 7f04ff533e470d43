"""What the disks can touch besides each other: the boundary of the workspace, and the things in it.

Shapes of arrays as in `world.judge.clearance`. Of p robots and m things, gaps are to the boundary robot by
robot, then to each thing robot by robot: (..., p + m p). Everything is measured in continuous time: during
straight motion at constant speed the distance from a convex set is a convex function of time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from protocol.geometry import ConvexPolygon, Disk, Shape

Reals = NDArray[np.float64]
Plane = NDArray[np.complex128]
Interval = tuple[float, float]

_TINY = np.finfo(np.float64).tiny
_THIRDS = 80  # of an interval: what is left is below a double's resolution of it


class Surroundings:
    """The boundary and the things of a scenario, for disks of given radii.

    Args:
        room: the workspace.
        things: what stands in it, by number.
        radii: of the robots, (p,) m.

    Attributes:
        room, radii: as given.
        shapes: the things in the order of their numbers.
        wall: distance from the origin at which each robot touches the boundary of a round room, rho_0i, m.
    """

    def __init__(self, room: Shape, things: Mapping[int, Shape], radii: Reals) -> None:
        self.room, self.radii = room, radii
        self.numbers, self.shapes = tuple(things), tuple(things.values())
        self.wall: Reals = (room.radius if isinstance(room, Disk) else np.inf) - radii
        self._disks = [index for index, shape in enumerate(self.shapes) if isinstance(shape, Disk)]
        self._polygons = [index for index, shape in enumerate(self.shapes) if not isinstance(shape, Disk)]
        self._centres: Plane = np.array(
            [complex(shape.around.x, shape.around.y) for shape in self.shapes], dtype=np.complex128
        )
        self._sizes: Reals = np.array([shape.around.radius for shape in self.shapes])
        self._corners = _padded([shape for shape in self.shapes if isinstance(shape, ConvexPolygon)])

    def __len__(self) -> int:
        """Number of gaps of a configuration."""
        return len(self.radii) * (1 + len(self.shapes))

    def gaps(self, before: Plane, after: Plane) -> Reals:
        """Smallest gap during motion from `before` to `after`, (n, p) each; negative is overlap, m."""
        to_wall = self._to_wall(before, after)
        if not self.shapes:
            return to_wall
        to_things = np.empty((*before.shape[:-1], len(self.shapes), before.shape[-1]))
        start = before[..., None, :] - self._centres[self._disks][:, None]
        to_things[..., self._disks, :] = closest(start, (after - before)[..., None, :])
        to_things[..., self._disks, :] -= self._sizes[self._disks][:, None]
        if self._polygons:
            to_things[..., self._polygons, :] = _from_polygons(self._corners, before, after)
        to_things -= self.radii
        return np.concatenate((to_wall, to_things.reshape(*before.shape[:-1], -1)), axis=-1)

    def _to_wall(self, before: Plane, after: Plane) -> Reals:
        if isinstance(self.room, Disk):
            return self.wall - np.maximum(np.abs(before), np.abs(after))
        rooms = [
            offset - np.maximum(_along(nx, ny, before), _along(nx, ny, after))
            for nx, ny, offset in self.room.sides
        ]
        smallest: Reals = np.min(rooms, axis=0) - self.radii
        return smallest

    def beta(self, positions: Plane) -> Reals:
        """beta of every robot with the boundary and with each thing, (n, ...) m^2; straight walls count each.

        A disk's is |b - c|^2 - (rho + r)^2, that of anything else d^2 - rho^2, d the distance of b from it.
        """
        if isinstance(self.room, Disk):
            walls = self.wall**2 - positions.real**2 - positions.imag**2
        else:
            rooms = [offset - _along(nx, ny, positions) for nx, ny, offset in self.room.sides]
            walls = np.concatenate([_squared_gap(room, self.radii) for room in rooms], axis=-1)
        if not self.shapes:
            return walls
        distances = self.gaps(positions, positions)[..., len(self.radii) :]
        distances = distances.reshape(*positions.shape[:-1], len(self.shapes), -1) + self.radii
        sizes = np.zeros(len(self.shapes))
        sizes[self._disks] = self._sizes[self._disks]
        with_things = _squared_gap(distances + sizes[:, None], self.radii + sizes[:, None])
        return np.concatenate((walls, with_things.reshape(*positions.shape[:-1], -1)), axis=-1)

    def overlaps(self, index: int, before: complex, after: complex, touch: float) -> list[Interval]:
        """When, during straight motion, gap `index` of `gaps` is below -touch; within [0, 1]."""
        thing, robot = divmod(index, len(self.radii))
        radius = float(self.radii[robot])
        shape = self.shapes[thing - 1] if thing else self.room

        def distance(time: float) -> float:
            place = before + time * (after - before)
            return shape.distance(place.real, place.imag)

        if thing:
            found = sublevel(distance, radius - touch)
            return [] if found is None else [found]
        found = sublevel(distance, touch - radius)
        if found is None:
            return [(0.0, 1.0)]
        return [part for part in ((0.0, found[0]), (found[1], 1.0)) if part[0] < part[1]]


def closest(start: Plane, motion: Plane) -> Reals:
    """Smallest distance from the origin on the way from `start` to `start + motion`."""
    squared = motion.real**2 + motion.imag**2
    along = start.real * motion.real + start.imag * motion.imag
    nearest = np.clip(-along / np.maximum(squared, _TINY), 0.0, 1.0)
    return np.abs(start + nearest * motion)


def sublevel(convex: Callable[[float], float], level: float) -> Interval | None:
    """The part of [0, 1] in which a convex function is at most `level`."""
    low, high = 0.0, 1.0
    for _ in range(_THIRDS):
        third = (high - low) / 3.0
        if convex(low + third) < convex(high - third):
            high -= third
        else:
            low += third
    lowest = min((0.0, low, 1.0), key=convex)
    if convex(lowest) > level:
        return None
    return _edge(convex, level, lowest, 0.0), _edge(convex, level, lowest, 1.0)


def _edge(convex: Callable[[float], float], level: float, inside: float, outside: float) -> float:
    """Where, between a time inside and an end of the interval, the level is crossed; the end if nowhere."""
    if convex(outside) <= level:
        return outside
    for _ in range(_THIRDS):
        middle = 0.5 * (inside + outside)
        if convex(middle) <= level:
            inside = middle
        else:
            outside = middle
    return inside


def _along(nx: float, ny: float, positions: Plane) -> Reals:
    product: Reals = nx * positions.real + ny * positions.imag
    return product


def _squared_gap(distances: Reals, contact: Reals) -> Reals:
    """distance^2 - contact^2; -contact^2 where the distance is negative."""
    return np.maximum(distances, 0.0) ** 2 - contact**2


def _padded(polygons: list[ConvexPolygon]) -> Plane:
    """Corners of all, (m, K); those with fewer repeat their last one."""
    most = max((len(polygon.points) for polygon in polygons), default=0)
    rows = [[complex(*point) for point in polygon.points] for polygon in polygons]
    return np.array([row + row[-1:] * (most - len(row)) for row in rows], dtype=np.complex128)


def _from_polygons(corners: Plane, before: Plane, after: Plane) -> Reals:
    """Smallest distance of moving points from convex polygons, (n, m, p) m; inside, minus the depth."""
    distance: Reals
    edges = np.roll(corners, -1, axis=1) - corners
    begin, end = before[..., None, :, None], after[..., None, :, None]  # (n, 1, p, 1)
    corner, edge = corners[:, None, :], edges[:, None, :]  # (m, 1, K)
    distance = np.minimum(closest(begin - corner, end - begin), closest(corner - begin, edge))
    distance = np.minimum(distance, closest(corner - end, edge)).min(axis=-1)
    lengths = np.abs(edge)
    normals = np.where(lengths > 0.0, -1j * edge / np.maximum(lengths, _TINY), 0.0)
    first = ((begin - corner) * normals.conj()).real  # signed distances from the sides
    slope = ((end - begin) * normals.conj()).real
    inside = _enters(np.where(lengths > 0.0, first, -np.inf), slope)
    for place in np.argwhere(inside):
        n, m, p = place
        sides = lengths[m, 0] > 0.0
        distance[n, m, p] = _deepest(first[n, m, p][sides], slope[n, m, p][sides])
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
    """The smallest value of the largest of first + t slope, t in [0, 1]."""
    low, high = 0.0, 1.0
    for _ in range(_THIRDS):
        third = (high - low) / 3.0
        if (first + (low + third) * slope).max() < (first + (high - third) * slope).max():
            high -= third
        else:
            low += third
    return float(min((first + t * slope).max() for t in (0.0, low, 1.0)))
