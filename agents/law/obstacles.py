"""Static obstacles: their repulsion, and the attraction around them.

Disks enter beta as in a sphere world (Koditschek and Rimon, "Robot navigation functions on manifolds with
boundary", 1990): beta = |x - c|^2 - (rho + r)^2. Of a convex set, or a straight wall, at the distance d(x),
beta = d^2 - rho^2. The gradient of d^2 is 2 (x - q), q the nearest point: that of a disk of radius 0 at q.

Attraction straight to the goal has a minimum behind a straight face that is turned away from the goal,
whatever k: the face curves less than the circle around the goal. So where obstacles are not the disks of a
sphere world, the distance to the goal is taken along the shortest way, in the visibility graph of the
obstacles, each widened by the own radius (Lozano-Perez and Wesley, 1979).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from agents.law.distance_field import Clearances, FieldRoute, clearances
from agents.law.passages import OUTSIDE, gaps
from agents.peers.state import Peer
from protocol.geometry import Disk, Shape, is_sphere_world
from protocol.messages import Vector

Reals = NDArray[np.float64]
Plane = NDArray[np.complex128]

MARGIN: Final = 0.02  # clearance of paths from obstacles, own radii; twice at corners
NARROW: Final = 1e-4  # the same if no wider path leads to the goal
_DOOR: Final = 2.5  # radii, width of a gap below which paths use its middle
_ASIDE: Final = 0.6  # contact distances before and after a gap, from where the corners are visible
_ARC: Final = math.pi / 3.0  # largest arc of a rounded corner per point
_DISK: Final = 12  # points around a disk
_NEARER: Final = 0.98  # share of its clearance that a robot beside an obstacle has to keep
_CHUNK: Final = 1 << 14  # segments per vectorised step


class WayPoints:
    """Points beside the corners of all obstacles, and their mutual visibility. Immutable.

    Attributes:
        points: vertices of shortest paths, (n,).
        lengths: of the straight lines between them, (n, n) m; infinite if blocked.
    """

    def __init__(self, room: Shape, shapes: Sequence[Shape], radius: float, narrow: bool = False) -> None:
        margin = NARROW if narrow else MARGIN
        self._shapes, self._clear = list(shapes), radius * (1.0 + margin)
        self._segments = [_segments(shape) for shape in self._shapes]
        self._centres = np.array([complex(shape.around.x, shape.around.y) for shape in self._shapes])
        self._sizes = np.array([shape.around.radius for shape in self._shapes])
        rings = [_ring(each, radius * (1.0 + 2.0 * margin)) for each in self._shapes]
        if narrow:
            rings += [[point] for point in _through(room, shapes, radius)]
        points, before, after = _joined(rings)
        free = self._free(room, points)
        self.points = points[free]
        self.lengths = self._graph(before[free], after[free])

    def visible(self, begin: Plane, end: Plane, *beside: complex) -> NDArray[np.bool_]:
        """Which straight lines clear all obstacles; those near one of the places `beside` by less."""
        clear = np.full(len(self._shapes), self._clear)
        for place in beside:
            clear = np.minimum(clear, self._clearances(place))
        return self._seen(begin, end, clear)

    def _clearances(self, place: complex) -> Reals:
        """Clearance that a line with an end at `place` must keep from each obstacle, m."""
        return np.array([_NEARER * shape.distance(place.real, place.imag) for shape in self._shapes])

    def _free(self, room: Shape, points: Plane) -> NDArray[np.bool_]:
        """Which points are inside and clear of all obstacles."""
        free = [
            room.distance(z.real, z.imag) <= -self._clear
            and all(shape.distance(z.real, z.imag) >= self._clear for shape in self._shapes)
            for z in points.tolist()
        ]
        return np.array(free, dtype=bool)

    def _graph(self, before: Plane, after: Plane) -> Reals:
        """Lengths of lines that are tangent at both ends; shortest paths have no others."""
        points, count = self.points, len(self.points)
        lengths = np.full((count, count), np.inf)
        one, other = np.triu_indices(count, 1)
        tangent = _tangent(points, before, after, one, other) & _tangent(points, before, after, other, one)
        one, other = one[tangent], other[tangent]
        clear = np.full(len(self._shapes), self._clear)
        for begin in range(0, len(one), _CHUNK):
            i, j = one[begin : begin + _CHUNK], other[begin : begin + _CHUNK]
            seen = self._seen(points[i], points[j], clear)
            i, j = i[seen], j[seen]
            lengths[i, j] = lengths[j, i] = np.abs(points[i] - points[j])
        return lengths

    def _seen(self, begin: Plane, end: Plane, clear: Reals) -> NDArray[np.bool_]:
        """Which straight lines keep `clear` (m, by obstacle) of all obstacles."""
        seen = np.ones(len(begin), dtype=bool)
        for index, (corner, edge) in enumerate(self._segments):
            distance = _from_ways(self._centres[index], begin, end)
            near = np.flatnonzero(seen & (distance < self._sizes[index] + clear[index]))
            if len(near) and len(corner) > 1:
                distance = _apart(begin[near], end[near], corner, edge)
                seen[near] = distance >= clear[index]
            elif len(near):
                seen[near] = False
        return seen


@lru_cache(maxsize=16)
def way_points(room: Shape, shapes: tuple[Shape, ...], radius: float, narrow: bool = False) -> WayPoints:
    """The way points of disks of `radius` (m), shared by robots of one size in one process."""
    return WayPoints(room, shapes, radius, narrow)


class Route:
    """Shortest paths to one goal at a time."""

    def __init__(self, way_points: WayPoints) -> None:
        self._ways = way_points
        self._goal: Vector | None = None
        self._rest: Reals = np.empty(0)  # from each point to the goal, m

    def ahead(self, position: Vector, goal: Vector) -> tuple[Vector, float] | None:
        """First corner of the shortest path to the goal, and the path's length, m.

        The goal itself if nothing is in between; None if no path was found.
        """
        here = complex(*position)
        if goal != self._goal:
            self._goal, self._rest = goal, self._distances(complex(*goal))
        points = np.append(self._ways.points, complex(*goal))
        total = np.abs(points - here) + np.append(self._rest, 0.0)
        for index in np.argsort(total, kind="stable"):
            if not math.isfinite(total[index]):
                break
            if points[index] == here and index < len(self._rest):
                continue
            ends = (here, complex(*goal)) if index == len(self._rest) else (here,)
            if self._ways.visible(np.array([here]), points[index : index + 1], *ends)[0]:
                return (float(points[index].real), float(points[index].imag)), float(total[index])
        return None

    def _distances(self, goal: complex) -> Reals:
        """Distance of each point from the goal, m: Dijkstra's algorithm on the dense graph."""
        points, lengths = self._ways.points, self._ways.lengths
        seen = self._ways.visible(np.full(len(points), goal), points, goal)
        rest: Reals = np.where(seen, np.abs(points - goal), np.inf)
        open_ = np.ones(len(rest), dtype=bool)
        while open_.any():
            index = int(np.where(open_, rest, np.inf).argmin())
            if not (open_[index] and math.isfinite(rest[index])):
                break
            open_[index] = False
            rest = np.minimum(rest, rest[index] + lengths[index])
        return rest


def _through(room: Shape, shapes: Sequence[Shape], radius: float) -> list[complex]:
    """Points before and after narrow gaps on their middle lines."""
    points = []
    for gap in gaps(room, shapes, _DOOR * radius):
        if gap.width < 2.0 * radius:
            continue
        begin, end = complex(*gap.begin), complex(*gap.end)
        ahead = 1j * (end - begin) / gap.width
        sizes = {_radius(shapes, index) for index in (gap.one, gap.other)}
        for size in sizes:
            way = _ASIDE * (size + radius) * ahead
            points += [0.5 * (begin + end) - way, 0.5 * (begin + end) + way]
    return points


def _radius(shapes: Sequence[Shape], index: int) -> float:
    """Radius of a round obstacle, m; 0 for others and the outside."""
    shape = shapes[index] if index != OUTSIDE else None
    return shape.radius if isinstance(shape, Disk) else 0.0


def _segments(shape: Shape) -> tuple[Plane, Plane]:
    """Corners and sides; of a disk its centre only."""
    if isinstance(shape, Disk):
        return np.array([complex(shape.x, shape.y)]), np.zeros(1, dtype=np.complex128)
    corners = np.array([complex(*point) for point in shape.points])
    return corners, np.roll(corners, -1) - corners


def _ring(shape: Shape, clear: float) -> list[complex]:
    """Corners of a polygon around all points within `clear` (m) of a shape, counterclockwise."""
    if isinstance(shape, Disk):
        reach = (shape.radius + clear) / math.cos(math.pi / _DISK)
        turns = [math.tau * (n + 0.5) / _DISK for n in range(_DISK)]
        return [complex(shape.x + reach * math.cos(turn), shape.y + reach * math.sin(turn)) for turn in turns]
    ring = []
    for index, (x, y) in enumerate(shape.points):
        (ax, ay, _), (bx, by, _) = shape.sides[index - 1], shape.sides[index]
        first = math.atan2(ay, ax)
        arc = math.atan2(ax * by - ay * bx, ax * bx + ay * by)
        parts = max(1, math.ceil(arc / _ARC - 1e-9))
        reach = clear / math.cos(0.5 * arc / parts)
        for part in range(parts):
            turn = first + arc * (part + 0.5) / parts
            ring.append(complex(x + reach * math.cos(turn), y + reach * math.sin(turn)))
    return ring


def _joined(rings: Sequence[Sequence[complex]]) -> tuple[Plane, Plane, Plane]:
    """All points, with the previous and the next one in the ring of each."""
    parts = [np.array(ring, dtype=np.complex128) for ring in rings]
    empty = [np.empty(0, dtype=np.complex128)]
    return (
        np.concatenate(empty + parts),
        np.concatenate(empty + [np.roll(part, 1) for part in parts]),
        np.concatenate(empty + [np.roll(part, -1) for part in parts]),
    )


def _tangent(
    points: Plane, before: Plane, after: Plane, one: NDArray[np.intp], other: NDArray[np.intp]
) -> NDArray[np.bool_]:
    """Whether the line from `one` to `other` leaves the ring of `one` on one side."""
    way = (points[other] - points[one]).conj()
    left, right = (way * (before[one] - points[one])).imag, (way * (after[one] - points[one])).imag
    tolerance = 1e-9 * np.abs(way) ** 2
    tangent: NDArray[np.bool_] = ((left >= -tolerance) & (right >= -tolerance)) | (
        (left <= tolerance) & (right <= tolerance)
    )
    return tangent


def _from_ways(point: complex | Plane, begin: Plane, end: Plane) -> Reals:
    """Distance of points from straight lines, m."""
    way = end - begin
    square = np.maximum(np.abs(way) ** 2, np.finfo(np.float64).tiny)
    part = np.clip(((point - begin) * way.conj()).real / square, 0.0, 1.0)
    distance: Reals = np.abs(begin + part * way - point)
    return distance


def _apart(begin: Plane, end: Plane, corner: Plane, edge: Plane) -> Reals:
    """Distance of straight lines, (n,), from one convex polygon, m; 0 if they cross."""
    one, other = begin[:, None], end[:, None]
    distance = np.minimum(_from_ways(corner, one, other), _from_ways(one, corner, corner + edge))
    distance = np.minimum(distance, _from_ways(other, corner, corner + edge)).min(axis=1)
    sides = (edge.conj() * (one - corner)).imag, (edge.conj() * (other - corner)).imag
    crossing = (sides[0] * sides[1] < 0.0) & (
        ((other - one).conj() * (corner - one)).imag * ((other - one).conj() * (corner + edge - one)).imag
        < 0.0
    )
    meet: Reals = np.where(crossing.any(axis=1) | (np.array(sides) > 0.0).all(axis=(0, 2)), 0.0, distance)
    return meet


MANY: Final = 64  # obstacles beyond which paths are found on a grid, and only near ones repel
_SLACK: Final = 1.01  # radii: somewhat more than a robot moves before it looks through all again
_TWO: Final = 2.0  # radii from each side of a passage in which two robots can pass each other


def obstacle_disks(room: Shape, shapes: Iterable[Shape], x: float, y: float) -> list[Peer]:
    """Obstacles as disks seen from (x, y), m, with the straight walls of the room."""
    found: list[Peer] = []
    for shape in shapes:
        if isinstance(shape, Disk):
            found.append(Peer(shape.x, shape.y, shape.radius, 0.0))
        else:
            px, py = shape.nearest(x, y)
            found.append(Peer(px, py, 0.0, 0.0))
    if not isinstance(room, Disk):
        for nx, ny, offset in room.sides:
            away = offset - nx * x - ny * y
            found.append(Peer(x + away * nx, y + away * ny, 0.0, 0.0))
    return found


class Attraction:
    """The pull on one robot of `radius`, m.

    In a sphere world it is straight, as in Koditschek and Rimon's navigation functions; elsewhere gamma_i is
    the squared length of the shortest path, whose gradient leads to its first corner.

    Two robots that meet in a passage with room for one block each other. So unless a robot is alone, it uses
    passages in which two can pass, if these lead to its goal.

    Attributes:
        winds: whether paths lead around obstacles, as of the last `aim`.
        straight: length of the straight first part of the path of the last `aim`, m; infinite if it does
            not turn.
    """

    def __init__(self, room: Shape, radius: float, alone: bool = False) -> None:
        self._room, self._radius = room, radius
        self._widths = ((1.0, False), (1.0, True)) if alone else ((_TWO, False), (1.0, False), (1.0, True))
        self._obstacles: tuple[Shape, ...] = ()
        self._routes: list[Route | FieldRoute] = []
        self._clearances: Clearances | None = None
        self._seen_from: Vector | None = None
        self._seen: list[Shape] = []  # obstacles near that position
        self._goal: Vector | None = None
        self._choice = 0  # index of the route for this goal
        self.winds = False
        self.straight = math.inf

    @property
    def width(self) -> float:
        """Width of the narrowest passages that the last path may use, m."""
        return 2.0 * self._radius * (self._widths[self._choice][0] if self.winds else 1.0)

    def aim(self, position: Vector, goal: Vector, obstacles: Sequence[Shape]) -> Vector:
        """Point of attraction, m: as far as the goal along the path, straight ahead of `position`."""
        self.straight = math.inf
        if not obstacles:
            self._obstacles, self.winds = (), False
            return goal
        self._follow(obstacles)
        if goal != self._goal:
            self._goal, self._choice = goal, 0
        found = self._ahead(position, goal) if self.winds else None
        if found is None or found[0] == goal:
            return goal
        (x, y), length = found
        dx, dy = x - position[0], y - position[1]
        self.straight = math.hypot(dx, dy)
        scale = length / self.straight
        return position[0] + scale * dx, position[1] + scale * dy

    def repelling(self, position: Vector, obstacles: Sequence[Shape]) -> list[Peer]:
        """Repelling obstacles at `position` (m), as disks; of very many only near ones."""
        self._follow(obstacles)
        near = self._near(*position) if len(obstacles) > MANY else obstacles
        return obstacle_disks(self._room, near, *position)

    def _near(self, x: float, y: float) -> list[Shape]:
        """Obstacles within reach of (x, y). All of them are examined once in several ticks: of 3000 this
        takes a fifth of a tick."""
        if self._seen_from is None or math.dist(self._seen_from, (x, y)) > self._radius:
            self._seen_from, self._seen = (x, y), self._map.near(x, y, _SLACK * self._radius)
        near: list[Shape] = []
        for shape in self._seen:
            around = shape.around
            reach, dx, dy = self._map.reach + around.radius, around.x - x, around.y - y
            if dx * dx + dy * dy <= reach * reach:
                near.append(shape)
        return near

    def leads(self, start: Vector, goal: Vector, obstacles: Sequence[Shape]) -> bool:
        """Whether a path from `start` to `goal` was found."""
        self.aim(start, goal, obstacles)
        return not self.winds or self._ahead(start, goal) is not None

    def way(self, start: Vector, goal: Vector, obstacles: Sequence[Shape]) -> list[Vector]:
        """Corners of the path from `start`, ending with the goal, m."""
        if not (self.leads(start, goal, obstacles) and self.winds):
            return [goal]
        corners = [start]
        while corners[-1] != goal:
            found = self._ahead(corners[-1], goal)
            corners.append(goal if found is None else found[0])
        return corners[1:]

    def prepare(self, obstacles: Sequence[Shape]) -> None:
        """Make the map of very many obstacles: it takes seconds, which a tick does not have."""
        self._follow(obstacles)
        if len(self._obstacles) > MANY:
            _ = self._map

    def _ahead(self, position: Vector, goal: Vector) -> tuple[Vector, float] | None:
        """Path through the widest possible passages. Once narrow ones are needed, they remain in use for this
        goal, so that no robot alternates between two paths for ever.
        """
        for choice in range(self._choice, len(self._widths)):
            found = self._route(choice).ahead(position, goal)
            if found is not None:
                self._choice = choice
                return found
        return None

    def _follow(self, obstacles: Sequence[Shape]) -> None:
        obstacles = tuple(obstacles)  # an unchanged tuple is the same object, which saves a comparison
        if obstacles is self._obstacles:
            return
        known, self._obstacles = self._obstacles, obstacles
        if obstacles == known:
            return
        self._routes, self._choice = [], 0
        self._clearances = self._seen_from = None
        self.winds = not is_sphere_world(self._room, dict(enumerate(obstacles, 1)), self._radius)

    @property
    def _map(self) -> Clearances:
        if self._clearances is None:
            self._clearances = clearances(self._room, self._obstacles, self._radius)
        return self._clearances

    def _route(self, choice: int) -> Route | FieldRoute:
        """Paths through passages of one width, prepared when first needed."""
        while len(self._routes) <= choice:
            width, narrow = self._widths[len(self._routes)]
            self._routes.append(self._ways(width * self._radius, narrow))
        return self._routes[choice]

    def _ways(self, clear: float, narrow: bool) -> Route | FieldRoute:
        if len(self._obstacles) > MANY:
            return FieldRoute(self._map, clear)
        return Route(way_points(self._room, self._obstacles, clear, narrow))
