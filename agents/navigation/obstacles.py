"""What stands, as the navigation function sees it from where a robot is.

Disks enter beta as in a sphere world (Koditschek and Rimon, "Robot navigation functions on manifolds with
boundary", 1990): beta = |x - c|^2 - (rho + r)^2. Of a convex set in general, d(x) the distance from it,
beta = d^2 - rho^2. The gradient of d^2 is 2 (x - q), q the nearest point: that of a disk of radius 0 at q. So
is a straight wall of the room.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from agents.navigation.slice import Peer
from protocol.geometry import Disk, Shape

_REMOTE: Final = (
    1e6  # times its size, from a room with straight walls: a round boundary that counts for nothing
)


def round_boundary(room: Shape) -> float:
    """Radius of the boundary that the slice takes for beta_0i, m."""
    if isinstance(room, Disk):
        return room.radius
    (left, low), (right, high) = room.box
    return _REMOTE * max(-left, -low, right, high, right - left, high - low)


def standing(room: Shape, shapes: Iterable[Shape], x: float, y: float) -> list[Peer]:
    """All that stands as seen from (x, y), m; straight walls of the room included."""
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
