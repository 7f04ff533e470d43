"""Reciprocal half-planes of velocities, and the velocity nearest to a wish under them and a speed limit.

Of two robots each leaves itself the velocities of one half-plane; if both keep to theirs, they do not touch
within the horizon (van den Berg, Guy, Lin, Manocha, "Reciprocal n-Body Collision Avoidance", 2011, section
4). The nearest velocity, or the one that violates them least, comes of two linear programs in few
variables, solved one constraint after another (Seidel; de Berg et al., "Computational Geometry", chapter
4), the second as in section 5 there.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from agents.lines.line import HalfPlane
from protocol.messages import Vector

_PARALLEL: Final = 1e-12
_ROUNDING: Final = 1e-12  # of the speed limit: a violation by less is none


def reciprocal(
    rx: float,
    ry: float,
    contact: float,
    vx: float,
    vy: float,
    ux: float,
    uy: float,
    horizon: float,
    share: float,
) -> HalfPlane:
    """Own velocities n.v <= limit.

    Args:
        rx, ry: from the own centre to the other's, m, farther than `contact` apart.
        contact: distance at which they touch, m.
        vx, vy: own velocity that both reckon with, m/s.
        ux, uy: the other's, m/s.
        horizon: s.
        share: of the change of relative velocity that this robot takes upon itself.
    """
    dx, dy = vx - ux, vy - uy
    square = rx * rx + ry * ry
    wx, wy = dx - rx / horizon, dy - ry / horizon  # from the centre of the obstacle's round end
    size = math.hypot(wx, wy)
    ahead = wx * rx + wy * ry
    if ahead < 0.0 and -ahead > contact * size:
        nx, ny = -wx / size, -wy / size
        depth = contact / horizon - size
    else:
        leg = math.sqrt(max(0.0, square - contact * contact))
        turn = leg if rx * wy - ry * wx > 0.0 else -leg
        nx, ny = (rx * contact + ry * turn) / square, (ry * contact - rx * turn) / square
        depth = nx * dx + ny * dy
    return HalfPlane(nx, ny, nx * vx + ny * vy - share * depth)


def nearest(wish: Vector, limits: Sequence[HalfPlane], speed: float, hard: int = 0) -> Vector:
    """The velocity, m/s.

    Args:
        wish: m/s.
        limits: of velocities, m/s.
        speed: the largest, m/s.
        hard: the first so many half-planes leave room together, and are kept where all are too many.
    """
    x, y = wish
    length = math.hypot(x, y)
    if length > speed:
        x, y = x * speed / length, y * speed / length
    for index, edge in enumerate(limits):
        if edge.nx * x + edge.ny * y > edge.limit + _ROUNDING * speed:
            found, x_new, y_new = _on_edge(limits, index, speed, wish[0], wish[1], False)
            if not found:
                return _least(limits, index, (x, y), speed, hard)
            x, y = x_new, y_new
    return x, y


def _least(limits: Sequence[HalfPlane], begin: int, velocity: Vector, speed: float, hard: int) -> Vector:
    """The velocity that violates the worst of all but the hard half-planes least, from `begin` on."""
    x, y = velocity
    worst = 0.0
    for index in range(max(begin, hard), len(limits)):
        edge = limits[index]
        if edge.nx * x + edge.ny * y - edge.limit <= worst:
            continue
        # Where this half-plane is violated more than every earlier one: as far to its inside as they allow.
        others = list(limits[:hard])
        for other in limits[hard:index]:
            nx, ny = other.nx - edge.nx, other.ny - edge.ny
            size = math.hypot(nx, ny)
            if size > _PARALLEL:
                others.append(HalfPlane(nx / size, ny / size, (other.limit - edge.limit) / size))
        found, x_new, y_new = _farthest(others, -edge.nx, -edge.ny, speed)
        if found:
            x, y = x_new, y_new
        worst = edge.nx * x + edge.ny * y - edge.limit
    return x, y


def _farthest(limits: Sequence[HalfPlane], dx: float, dy: float, speed: float) -> tuple[bool, float, float]:
    """The velocity farthest in the unit direction (dx, dy), if there is any."""
    x, y = dx * speed, dy * speed
    for index, edge in enumerate(limits):
        if edge.nx * x + edge.ny * y > edge.limit + _ROUNDING * speed:
            found, x, y = _on_edge(limits, index, speed, dx, dy, True)
            if not found:
                return False, 0.0, 0.0
    return True, x, y


def _on_edge(
    limits: Sequence[HalfPlane], index: int, speed: float, wx: float, wy: float, far: bool
) -> tuple[bool, float, float]:
    """The point on the edge of one half-plane, within all earlier ones, nearest to (wx, wy), or `far` in that
    direction; and whether there is any."""
    edge = limits[index]
    nx, ny, limit = edge.nx, edge.ny, edge.limit
    square = speed * speed - limit * limit
    if square < 0.0:
        return False, 0.0, 0.0
    high = math.sqrt(square)
    low = -high
    for other in limits[:index]:
        along = nx * other.ny - ny * other.nx  # m . t with the edge's direction t = (-ny, nx)
        room = other.limit - limit * (other.nx * nx + other.ny * ny)
        if along > _PARALLEL:
            high = min(high, room / along)
        elif along < -_PARALLEL:
            low = max(low, room / along)
        elif room < -_ROUNDING * speed:
            return False, 0.0, 0.0
    if low > high:
        return False, 0.0, 0.0
    along = nx * wy - ny * wx
    if far:
        along = high if along > 0.0 else low
    along = min(max(along, low), high)
    return True, limit * nx - along * ny, limit * ny + along * nx
