"""The applied velocity: the nearest one to the desired velocity that obeys all constraints until it expires.

A convex program in two variables: half-planes, the boundary, the speed disk. All contain 0, so standing still
is always allowed, and phi decreases with any positive scale or projection.

Execution noise turns v into v + |v| w with |w| <= noise < 1. For a half-plane n.d <= s of displacements, n.d
+ noise |d| <= s is required: one branch of a hyperbola around n. The wedge from its apex along its asymptotes
lies inside it, is exact for s = 0, and consists of two half-planes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, final

from agents.lines.boundary import Boundary
from agents.lines.own_set import Polygon
from protocol.bodies.sweep import Sweep
from protocol.line import HalfPlane, room_of
from protocol.messages import Vector

_CUTS: Final = 12  # half-planes of the boundary that are tried
_TINY: Final = 1e-100  # m; what can be divided by
_SHRINK = (1.0, 1.0, 1.0 - 1e-15, 1.0 - 1e-12, 1.0 - 1e-9, 1.0 - 1e-6, 0.999, 0.99, 0.9, 0.5, 0.0)


@final
class Limits:
    """Constraints of a robot in a tick.

    Args:
        position: estimated own centre, m.
        half_planes: constraints on the estimated centre; no violation may increase.
        boundaries: of the true centre.
        shape: possible offsets of the true centre from the estimate; None if it is exact.
    """

    def __init__(
        self,
        position: Vector,
        half_planes: Sequence[HalfPlane],
        boundaries: Sequence[Boundary],
        shape: Polygon | None,
    ) -> None:
        self.position, self.half_planes = position, half_planes
        self.boundaries, self.shape = boundaries, shape

    def left(self, step: Vector, noise: float, tolerance: float = 0.0) -> HalfPlane | None:
        """A half-plane that a displacement violates by leaving a boundary; as `RoundBoundary.cut`."""
        for boundary in self.boundaries:
            cut = boundary.cut(self.position, self.shape, step, noise, tolerance)
            if cut is not None:
                return cut
        return None

    def cut(self, passed: Sweep) -> HalfPlane | None:
        """A half-plane of displacements that a sweep violates by leaving the boundary."""
        found: HalfPlane | None = None
        for index, margin in enumerate(passed.margins):
            dx, dy = passed.xs[index], passed.ys[index]
            if dx == dy == 0.0 and margin > 0.0:
                dx = _TINY  # a path back to its start, except for the margin
            way = math.hypot(dx, dy)
            if way > 0.0:
                cut = self.left((dx, dy), margin / way)
                found = cut if cut is not None else found
        return found


def safe_velocity(
    desired: Vector, limits: Limits, *, speed: float, period: float, noise: float = 0.0
) -> Vector:
    """The velocity nearest to `desired`, m/s, that keeps to the limits until `period` is over.

    The result satisfies every constraint in floating point, with inward rounding.

    Args:
        speed: speed limit, m/s.
        period: how long the command holds, s.
        noise: bound on the relative execution noise, in [0, 1).
    """
    if desired == (0.0, 0.0):
        return desired
    max_step = speed * period
    want = (desired[0] * period, desired[1] * period)
    near = _near(limits, max_step * (1.0 + noise))
    if noise > 0.0:
        near = [half for limit in near for half in wedge(limit, noise)]
    step = nearest(want, near, max_step)
    for _ in range(_CUTS):
        cut = limits.left(step, noise, 1e-12)
        if cut is None:
            break
        near = [*near, *(wedge(cut, noise) if noise > 0.0 else (cut,))]
        step = nearest(want, near, max_step)
    for shrink in _SHRINK:
        # Shrinking makes room at all edges but those through 0; only then can these be moved off.
        step = _nudged((step[0] * shrink, step[1] * shrink), near)
        vx, vy = step[0] / period, step[1] / period
        dx, dy = vx * period, vy * period
        if (
            math.hypot(dx, dy) <= max_step
            and math.hypot(vx, vy) * period <= max_step
            and all(each.nx * dx + each.ny * dy <= each.limit for each in near)
            and limits.left((dx, dy), noise) is None
        ):
            return vx, vy
    return 0.0, 0.0


def _near(limits: Limits, max_step: float) -> list[HalfPlane]:
    """The half-planes within reach, for displacements: n.d <= room."""
    (x, y), near = limits.position, []
    for each in limits.half_planes:
        slack = each.slack(x, y)
        if slack < max_step:
            room = room_of(slack, x, y) if limits.shape is None else max(0.0, slack)
            near.append(HalfPlane(each.nx, each.ny, room))
    return near


def wedge(limit: HalfPlane, noise: float) -> tuple[HalfPlane, HalfPlane]:
    """Two half-planes inside {d: n.d + noise |d| <= s}, with edges along the asymptotes from its apex: s/(1 +
    noise) n, or s/(1 - noise) n if s < 0, where the displacement has to lead away.
    """
    nx, ny, slack = limit.nx, limit.ny, limit.limit
    cosine = math.sqrt(1.0 - noise * noise)
    offset = slack * cosine / (1.0 + noise if slack >= 0.0 else 1.0 - noise)
    return (
        HalfPlane(cosine * nx - noise * ny, noise * nx + cosine * ny, offset),
        HalfPlane(cosine * nx + noise * ny, cosine * ny - noise * nx, offset),
    )


def nearest(want: Vector, limits: Sequence[HalfPlane], max_step: float) -> Vector:
    """The point nearest to `want` in a disk of radius `max_step` around 0 and all half-planes.

    One constraint after another: the nearest point so far remains if the next one allows it; otherwise the
    new one is on that constraint's edge, a problem in one variable (Seidel; de Berg et al., "Computational
    Geometry", chapter 4).
    """
    px, py = want
    length = math.hypot(px, py)
    if length > max_step:
        px, py = px * max_step / length, py * max_step / length
    for index, edge in enumerate(limits):
        if edge.nx * px + edge.ny * py > edge.limit:
            px, py = _on_edge(want, limits, index, max_step)
    return px, py


def _on_edge(want: Vector, limits: Sequence[HalfPlane], index: int, max_step: float) -> Vector:
    """The point nearest to `want` on the edge of one half-plane, within the disk and all earlier ones."""
    edge = limits[index]
    nx, ny, limit = edge.nx, edge.ny, edge.limit
    high = math.sqrt(max(0.0, max_step * max_step - limit * limit))
    low = -high
    for other in limits[:index]:
        along = nx * other.ny - ny * other.nx  # m . t with the edge's direction t = (-ny, nx)
        room = other.limit - limit * (other.nx * nx + other.ny * ny)
        if along > 1e-15:
            high = min(high, room / along)
        elif along < -1e-15:
            low = max(low, room / along)
    along = nx * want[1] - ny * want[0]
    if low > high:  # only by rounding, since 0 is allowed
        low = high = 0.5 * (low + high)
    along = min(max(along, low), high)
    return limit * nx - along * ny, limit * ny + along * nx


def _nudged(step: Vector, limits: Sequence[HalfPlane]) -> Vector:
    """A displacement moved off the edges that it is on, by the possible rounding error."""
    dx, dy = step
    push = 4e-16 * (abs(dx) + abs(dy))
    for each in limits:
        if each.nx * dx + each.ny * dy > each.limit - push:
            dx -= 2.0 * push * each.nx
            dy -= 2.0 * push * each.ny
    return dx, dy
