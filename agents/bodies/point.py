"""A point: it takes every velocity at once, and stands when the tick is over."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

from agents.lines.boundary import Boundary
from agents.lines.line import HalfPlane
from agents.lines.polygon import Polygon
from agents.lines.safe_velocity import safe_velocity
from protocol.bodies.sweep import Sweep
from protocol.messages import BaseMotion, Vector


@final
class PointBody:
    """See `agents.bodies.body.Body`.

    Args:
        speed: speed limit, m/s.
        period: of a tick, s.
        noise: bound on the relative execution noise.
    """

    def __init__(self, speed: float, period: float, noise: float) -> None:
        self.reach = speed * (1.0 + noise) * period
        self.berth = 0.0
        self.swept: Sweep | None = None
        self._speed, self._period, self._noise = speed, period, noise

    def on_motion(self, motion: BaseMotion | None) -> None:
        """It stands."""

    def velocity(
        self,
        desired: Vector,
        position: Vector,
        half_planes: Sequence[HalfPlane],
        boundary: Boundary,
        shape: Polygon | None,
    ) -> Vector:
        """The nearest to the desired one."""
        return safe_velocity(
            desired,
            position,
            half_planes,
            boundary=boundary,
            speed=self._speed,
            period=self._period,
            shape=shape,
            noise=self._noise,
        )
