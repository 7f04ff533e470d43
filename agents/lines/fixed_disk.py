"""A fenced peer: a disk that stands still for ever, instead of a line that nobody else can move."""

from __future__ import annotations

import math
from collections.abc import Iterable

from agents.lines.line import ROUNDING, HalfPlane
from agents.polygon import Polygon
from protocol.bodies.sweep import Sweep


class FixedDisk:
    """Keeps to the tangent half-plane between the own present position and the disk, renewed every tick.

    A new tangent is taken only when the own disk surely satisfies it; until then the last one stays
    in force, first of all the obeyed line behind which the disk was left.

    Args:
        x, y: centre of the fenced disk, m.
        radius: its radius, m.
        own_radius: radius of this robot, m.
        obeyed: half-planes for the own centre that were obeyed so far.

    Attributes:
        x, y: as given.
        half_plane: where the own centre stays; None while the own disk is not known to be clear.
    """

    def __init__(
        self, x: float, y: float, radius: float, own_radius: float, obeyed: Iterable[HalfPlane]
    ) -> None:
        self.x, self.y = x, y
        self._contact = radius + own_radius
        behind = (side for side in obeyed if -side.slack(x, y) >= self._contact)
        self.half_plane = next(behind, None)  # None: not known to be clear of the disk, so stand still

    def renew(
        self, x: float, y: float, bound: float, shape: Polygon | None = None, swept: Sweep | None = None
    ) -> None:
        """Turn the half-plane towards the own position (x, y), known to within `bound`, m, or to `shape`;
        from there the body passes `swept`."""
        dx, dy = self.x - x, self.y - y
        distance = math.hypot(dx, dy)
        if distance == 0.0:
            return
        nx, ny = dx / distance, dy / distance
        tangent = HalfPlane(nx, ny, nx * self.x + ny * self.y - self._contact)
        extent = bound if shape is None else shape.extent(nx, ny)
        if swept is not None:
            extent += swept.extent(nx, ny)
        if tangent.slack(x, y) >= extent + ROUNDING:
            self.half_plane = tangent
