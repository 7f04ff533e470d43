"""Gaps between obstacles, and between obstacles and the outside of the workspace."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

import numpy as np

from protocol.geometry import ConvexPolygon, Disk, Shape
from protocol.messages import Vector

OUTSIDE: Final = -1  # index of the outside of the workspace, among obstacles


class Gap(NamedTuple):
    """The shortest connection of two obstacles, or of an obstacle with the outside of the workspace."""

    one: int  # index of the obstacle
    other: int  # index of the other one, or OUTSIDE
    begin: Vector  # point of the one, m
    end: Vector  # point of the other one, m
    width: float  # m; 0 where they overlap


def gaps(room: Shape, obstacles: Sequence[Shape], below: float = math.inf) -> list[Gap]:
    """All gaps narrower than `below` (m), narrowest first.

    To the outside an obstacle has a gap at each corner where a disk may be stuck.
    """
    disks = [shape.around for shape in obstacles]
    x, y, radius = np.array([(disk.x, disk.y, disk.radius) for disk in disks]).reshape(-1, 3).T
    found = []
    for one, shape in enumerate(
        obstacles
    ):  # a thousand obstacles have half a million pairs, and few of them near
        apart = np.hypot(x[one + 1 :] - x[one], y[one + 1 :] - y[one]) - radius[one + 1 :] - radius[one]
        for other in (np.flatnonzero(apart < below) + one + 1).tolist():
            ends = _nearest(shape, obstacles[other])
            found.append(Gap(one, other, *ends, math.dist(*ends)))
    for one, shape in enumerate(obstacles):
        found += [Gap(one, OUTSIDE, *ends, math.dist(*ends)) for ends in _exits(room, shape)]
    return sorted((gap for gap in found if gap.width < below), key=lambda gap: gap.width)


def crosses(a: Vector, b: Vector, start: Vector, goal: Vector) -> bool:
    """Whether the straight lines from a to b and from start to goal cross; an end is on one side."""
    return (_left(start, goal, a) > 0.0) != (_left(start, goal, b) > 0.0) and (
        (_left(a, b, start) > 0.0) != (_left(a, b, goal) > 0.0)
    )


def _left(a: Vector, b: Vector, point: Vector) -> float:
    """Positive if a point is to the left of the line from a to b."""
    return (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0])


def _nearest(a: Shape, b: Shape) -> tuple[Vector, Vector]:
    """The nearest points of two obstacles, m; the same point twice if they overlap."""
    if isinstance(a, Disk) and isinstance(b, ConvexPolygon):
        end, begin = _nearest(b, a)
        return begin, end
    if isinstance(a, ConvexPolygon) and isinstance(b, ConvexPolygon):
        common = next(_common(a, b), None)
        if common is not None:
            return common, common
        pairs = [(p, b.nearest(*p)) for p in a.points] + [(a.nearest(*p), p) for p in b.points]
        return min(pairs, key=lambda pair: math.dist(*pair))
    begin = a.nearest(b.around.x, b.around.y)
    end = b.nearest(*begin)
    return begin, end


def _common(a: ConvexPolygon, b: ConvexPolygon) -> Iterator[Vector]:
    """Points of two polygons that overlap."""
    for one, other in ((a, b), (b, a)):
        yield from (point for point in one.points if other.distance(*point) <= 0.0)
    for p, q in zip(a.points, (*a.points[1:], a.points[0]), strict=True):
        for r, s in zip(b.points, (*b.points[1:], b.points[0]), strict=True):
            if crosses(p, q, r, s):
                before, after = _left(r, s, p), _left(r, s, q)
                part = before / (before - after)
                yield p[0] + part * (q[0] - p[0]), p[1] + part * (q[1] - p[1])


def _exits(room: Shape, shape: Shape) -> Iterator[tuple[Vector, Vector]]:
    """From an obstacle straight out of the workspace: at each side, or of a round one at each corner."""
    corners = [(shape.x, shape.y)] if isinstance(shape, Disk) else list(shape.points)
    inner = shape.radius if isinstance(shape, Disk) else 0.0
    if isinstance(room, Disk):
        for x, y in corners:
            dx, dy = x - room.x, y - room.y
            distance = math.hypot(dx, dy)
            nx, ny = (dx / distance, dy / distance) if distance > 0.0 else (1.0, 0.0)
            yield _out((x, y), nx, ny, inner, room.radius - distance)
        return
    for nx, ny, offset in room.sides:
        x, y = max(corners, key=lambda point: nx * point[0] + ny * point[1])
        yield _out((x, y), nx, ny, inner, offset - nx * x - ny * y)


def _out(corner: Vector, nx: float, ny: float, inner: float, left: float) -> tuple[Vector, Vector]:
    begin = corner[0] + inner * nx, corner[1] + inner * ny
    room = max(0.0, left - inner)
    return begin, (begin[0] + room * nx, begin[1] + room * ny)
