"""Boundaries that a disk must not leave, workspace and region, as half-planes.

A centre x that moves by d stays inside if n.(x + d) <= W for every direction n, W the largest distance from
the origin. Of x only a set is known, with support h(n), and that it is inside. So n.d <= max(0, W - h(n))
for every n suffices, and d = 0 is always allowed: for n = (x + d) / |x + d|, either n.d <= W - h(n), and
n.(x + d) <= W, or n.d <= 0, and n.(x + d) <= n.x <= W. As there are infinitely many n, `cut` gives one that a
displacement violates. Of a convex polygon the walls are all.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, final

from mypy_extensions import mypyc_attr

from agents.lines.own_set import Polygon
from protocol.geometry import Disk, Shape
from protocol.line import ROUNDING, HalfPlane, room_of
from protocol.messages import Vector

_WORTH: Final = 0.05  # least depth of a cut, radii of the set


@final
@mypyc_attr(acyclic=True)
class RoundBoundary:
    """A round boundary; `radius`: the largest distance W of the own centre from its centre (x, y), m."""

    def __init__(self, radius: float, x: float = 0.0, y: float = 0.0) -> None:
        self.radius, self.cx, self.cy = radius, x, y

    def beyond(self, x: float, y: float, shape: Polygon) -> HalfPlane | None:
        """The tangent that cuts off the outermost corner of `shape` around (x, y), if that is worth a cut."""
        far, fx, fy = self.radius + _WORTH * shape.radius, 0.0, 0.0
        x, y = x - self.cx, y - self.cy
        for index, vx in enumerate(shape.xs):
            px, py = x + vx, y + shape.ys[index]
            distance = math.hypot(px, py)
            if distance > far:
                far, fx, fy = distance, px, py
        if fx == fy == 0.0:
            return None
        nx, ny = fx / far, fy / far
        return HalfPlane(nx, ny, self.radius + nx * self.cx + ny * self.cy)

    def contains(self, x: float, y: float, bound: float) -> bool:
        """Whether all points within `bound` (m) of (x, y) are inside."""
        return math.hypot(x - self.cx, y - self.cy) + bound + ROUNDING <= self.radius

    def cut(
        self, place: Vector, shape: Polygon | None, step: Vector, noise: float = 0.0, tolerance: float = 0.0
    ) -> HalfPlane | None:
        """A half-plane of displacements that the displacement `step`, m, violates; None if it violates none.

        Args:
            place, shape: the set where the own centre can be, m; without `shape` it is the place.
            noise: bound on the relative execution noise: executed is d + |d| w, |w| <= noise.
            tolerance: ignored violation, as a share of the distance from the origin.
        """
        dx, dy = step
        extra = noise * math.hypot(dx, dy)
        x, y = place[0] - self.cx, place[1] - self.cy
        if shape is None:
            return self._cut_of_point(x, y, dx, dy, extra, tolerance)
        rim = self.radius - shape.margin - 2.0 * ROUNDING
        if rim <= 0.0:
            return _against(dx, dy)
        if math.hypot(x + dx, y + dy) + shape.radius + extra <= rim:
            return None
        worst = tolerance * rim
        wx = wy = limit = 0.0
        for index, vx in enumerate(shape.xs):
            px, py = x + vx, y + shape.ys[index]
            qx, qy = px + dx, py + dy
            distance = math.hypot(qx, qy)
            if distance + extra - rim <= worst:
                continue
            nx, ny = qx / distance, qy / distance
            room = rim - nx * px - ny * py
            if room < 0.0:  # this corner is outside, and may only return
                nx, ny = _edge_of_cone(px, py, dx, dy, rim)
                room = 0.0
            excess = nx * dx + ny * dy + extra - room
            if excess > worst:
                worst, wx, wy, limit = excess, nx, ny, room
        if wx == 0.0 and wy == 0.0:
            return None
        return HalfPlane(wx, wy, limit)

    def _cut_of_point(
        self, x: float, y: float, dx: float, dy: float, extra: float, tolerance: float
    ) -> HalfPlane | None:
        rim = max(self.radius, math.hypot(x, y))  # outside only by rounding
        qx, qy = x + dx, y + dy
        distance = math.hypot(qx, qy)
        if distance + extra <= rim * (1.0 + tolerance):
            return None
        nx, ny = qx / distance, qy / distance
        return HalfPlane(nx, ny, max(0.0, rim - nx * x - ny * y))


@final
@mypyc_attr(acyclic=True)
class StraightBoundary:
    """The walls of a convex room, as half-planes for the own centre."""

    def __init__(self, walls: Sequence[HalfPlane]) -> None:
        self.walls = list(walls)

    def beyond(self, x: float, y: float, shape: Polygon) -> HalfPlane | None:
        """The wall that cuts off the outermost part of `shape` around (x, y), if that is worth a cut."""
        far, found = _WORTH * shape.radius, None
        for wall in self.walls:
            out = shape.extent(wall.nx, wall.ny) - wall.slack(x, y)
            if out > far:
                far, found = out, wall
        return found

    def contains(self, x: float, y: float, bound: float) -> bool:
        """Whether all points within `bound` (m) of (x, y) are inside."""
        return all(wall.slack(x, y) >= bound + ROUNDING for wall in self.walls)

    def cut(
        self, place: Vector, shape: Polygon | None, step: Vector, noise: float = 0.0, tolerance: float = 0.0
    ) -> HalfPlane | None:
        """As `RoundBoundary.cut`; a violation by less than `tolerance`, m, does not count, unless it has to
        lead away."""
        (x, y), (dx, dy) = place, step
        extra = noise * math.hypot(dx, dy)
        worst, found = tolerance, None
        for wall in self.walls:
            extent = 0.0 if shape is None else shape.extent(wall.nx, wall.ny)
            slack = wall.slack(x, y) - extent - 2.0 * ROUNDING
            room = room_of(slack, x, y) if shape is None else max(0.0, slack)
            excess = wall.nx * dx + wall.ny * dy + extra - room
            if room < 0.0:
                excess += tolerance
            if excess > worst:
                worst, found = excess, HalfPlane(wall.nx, wall.ny, room)
        return found


Boundary = RoundBoundary | StraightBoundary


def boundary_of(room: Shape, radius: float) -> Boundary:
    """The boundary of a room for the centre of a disk of `radius`, m."""
    if isinstance(room, Disk):
        return RoundBoundary(room.radius - radius, room.x, room.y)
    return StraightBoundary([HalfPlane(nx, ny, offset - radius) for nx, ny, offset in room.sides])


def _against(dx: float, dy: float) -> HalfPlane | None:
    """A half-plane that forbids the displacement."""
    length = math.hypot(dx, dy)
    return HalfPlane(dx / length, dy / length, 0.0) if length > 0.0 else None


def _edge_of_cone(px: float, py: float, dx: float, dy: float, rim: float) -> tuple[float, float]:
    """Of the directions n with n.p >= rim, p outside, the one at the edge towards (dx, dy)."""
    distance = math.hypot(px, py)
    ux, uy = px / distance, py / distance
    cosine = rim / distance
    sine = math.sqrt(max(0.0, 1.0 - cosine * cosine))
    if ux * dy - uy * dx < 0.0:
        sine = -sine
    return cosine * ux - sine * uy, cosine * uy + sine * ux
