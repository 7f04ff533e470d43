"""Something that stands: a fenced peer's disk, or a thing. Nobody moves it, so no line has to be agreed."""

from __future__ import annotations

import math
from collections.abc import Iterable

from agents.lines.line import HalfPlane
from agents.lines.own_set import OwnSet
from protocol.geometry import Shape
from protocol.messages import Vector


class Tangent:
    """Keeps to the tangent half-plane between the own present position and a shape, renewed every tick.

    A new tangent is taken only when the own disk surely satisfies it; until then the last one stays
    in force, first of all an obeyed half-plane behind which the shape is.

    Args:
        shape: what stands.
        own_radius: radius of this robot, m.
        obeyed: half-planes for the own centre that were obeyed so far.

    Attributes:
        shape: as given.
        radius: of the own disk that keeps to it, m.
        half_plane: where the own centre stays; None while the own disk is not known to be clear.
    """

    def __init__(self, shape: Shape, own_radius: float, obeyed: Iterable[HalfPlane] = ()) -> None:
        self.shape, self.radius = shape, own_radius
        self._around = shape.around
        self.half_plane: HalfPlane | None = None  # not known to be clear of it, so stand still
        for side in obeyed:
            if shape.limit(side.nx, side.ny, own_radius) >= side.limit:
                self.half_plane = side
                break

    def renew(self, own: OwnSet, far: float = 0.0) -> None:
        """Turn the half-plane towards the own position.

        Of what is more than `far` (m) out of reach, the disk around it does.
        """
        around, x, y = self._around, own.x, own.y
        dx, dy = around.x - x, around.y - y
        distance = math.hypot(dx, dy)
        target: Shape = around
        if self.shape is not around and distance - around.radius - self.radius - own.bound <= far:
            target = self.shape
            px, py = self.shape.nearest(x, y)
            dx, dy = px - x, py - y
            distance = math.hypot(dx, dy)
        if distance == 0.0:
            return
        nx, ny = dx / distance, dy / distance
        tangent = HalfPlane(nx, ny, target.limit(nx, ny, self.radius))
        if own.satisfies(tangent):
            self.half_plane = tangent

    def resize(self, own_radius: float) -> None:
        """This robot is another disk: the same line, for the centre of that."""
        side = self.half_plane
        if side is not None and own_radius != self.radius:
            self.half_plane = HalfPlane(side.nx, side.ny, side.limit + self.radius - own_radius)
        self.radius = own_radius

    def lacking(self, x: float, y: float, room: float) -> Vector:
        """How far to back off from (x, y), m, to be clear of it by `room`, m."""
        px, py = self.shape.nearest(x, y)
        if px == x and py == y:
            px, py = self._around.x, self._around.y
        dx, dy = x - px, y - py
        distance = math.hypot(dx, dy)
        lacking = room + self.radius - self.shape.distance(x, y)
        if lacking <= 0.0:
            return 0.0, 0.0
        if distance == 0.0:
            return lacking, 0.0
        return lacking * dx / distance, lacking * dy / distance
