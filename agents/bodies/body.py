"""What a body is to the filter."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from agents.lines.boundary import Boundary
from agents.lines.line import HalfPlane
from agents.lines.polygon import Polygon
from protocol.bodies.sweep import Sweep
from protocol.messages import BaseMotion, Vector


class Body(Protocol):
    """One body from tick to tick.

    Attributes:
        reach: the longest way from the beginning of a tick until it stands, m.
        berth: how far it can stand off any edge and still leave it, whichever way it faces, m.
        swept: what its control point still passes if it hears nothing; None if it stands.
    """

    reach: float
    berth: float
    swept: Sweep | None

    def on_motion(self, motion: BaseMotion | None) -> None:
        """Take in what the base says that it does as a tick begins; None: it stands."""

    def velocity(
        self,
        desired: Vector,
        position: Vector,
        half_planes: Sequence[HalfPlane],
        boundary: Boundary,
        shape: Polygon | None,
    ) -> Vector:
        """The velocity to command, m/s, near the desired one: whatever is heard or lost after it, the control
        point keeps to the half-planes and inside the boundary.

        Args:
            desired: m/s.
            position: estimated own place, m.
            half_planes: where the estimated centre must stay.
            boundary: what the true centre must not leave.
            shape: where the true centre can be, around the estimated one; None where that is exact.
        """
        ...
