"""What carries a robot, as its filter sees it: a point, or a base that does not stop at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, final

from agents.bodies.inertial import InertialBody
from agents.lines.boundary import Boundary
from agents.lines.line import HalfPlane
from agents.lines.polygon import Polygon
from agents.lines.safe_velocity import safe_velocity
from protocol.bodies.kinematics import Kinematics
from protocol.bodies.sweep import Sweep, Tolerance
from protocol.messages import BaseMotion, Vector
from protocol.scenario.model import Scenario


class Body(Protocol):
    """One body from tick to tick.

    Attributes:
        reach: the longest way from the beginning of a tick until it stands, m.
        standoff: how far it can stand off any edge and still leave it, whichever way it faces, m.
        swept: what its control point still passes if it hears nothing; None if it stands.
    """

    reach: float
    standoff: float
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


def body_of(scenario: Scenario, robot: int) -> Body:
    """The body of one robot of a scenario."""
    body, speed, period = scenario.body_of(robot), scenario.control.speed, scenario.time.step
    longest = 2.0 * scenario.workspace.shape.around.radius  # no way inside the workspace leads farther
    if body.ideal:
        return PointBody(speed, period, scenario.actuation.bound, longest)
    tolerance = Tolerance(body, scenario.actuation.bound, scenario.sensing_of(robot).heading)
    return InertialBody(Kinematics(body, period), speed, tolerance, longest)


@final
class PointBody:
    """A point: it takes every velocity at once, and stands when the tick is over.

    Args:
        speed: speed limit, m/s.
        period: of a tick, s.
        noise: bound on the relative execution noise.
        longest: no way leads farther, m.
    """

    def __init__(self, speed: float, period: float, noise: float, longest: float) -> None:
        self.reach = min(speed * (1.0 + noise) * period, longest)
        self.standoff = 0.0
        self.swept: Sweep | None = None
        self._speed, self._period, self._noise = speed, period, noise

    def on_motion(self, motion: BaseMotion | None) -> None:
        """Nothing: it stands."""

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
