"""Odometry and direction: how far the base says that it went, and which way it says it faces."""

from __future__ import annotations

import math

from mypy_extensions import mypyc_attr

from protocol.bodies.kinematics import turned
from protocol.draws import Purpose
from protocol.messages import BaseMotion, Vector
from protocol.scenario.model import Scenario
from world.plants.disturbance import Uniforms
from world.plants.plant import Report

_INSIDE = 1.0 - 1e-9  # keeps rounding from carrying an error past its bound


@mypyc_attr(allow_interpreted_subclasses=True)
class Odometer:
    """What one robot's base reports, with errors up to those that the scenario states.

    A base steers by the direction that it believes it has, so whatever it says, and all that it is told, is
    in a frame that is turned by the same error in a tick.

    Args:
        slips: whether what the plant reports is not exact already; then no error is added to the way.
    """

    def __init__(self, scenario: Scenario, robot: int, slips: bool) -> None:
        body = scenario.body_of(robot)
        self._share, self._drift = body.odometry, body.drift
        self._heading = scenario.sensing_of(robot).heading
        self._slips = slips
        self._has_heading = not body.ideal and self._heading > 0.0
        self.ideal = body.ideal and self._share == self._drift == 0.0
        self._draws = Uniforms(scenario.seed, Purpose.ODOMETRY, robot, 3)

    def read(self, report: Report, tick: int) -> tuple[Vector, float, BaseMotion | None]:
        """Displacement in the tick before, its error bound (m), and what the base says that it does."""
        displacement = report.displacement
        if self.ideal:
            return displacement, 0.0, None
        dx, dy = displacement
        if not self._slips:
            size, direction, _ = self._draws.at(tick)
            off = math.sqrt(size) * _INSIDE * (self._share * report.way + self._drift)
            dx += off * math.cos(2.0 * math.pi * direction)
            dy += off * math.sin(2.0 * math.pi * direction)
        bound = (self._share * report.way + self._drift) / (1.0 - self._share)
        if report.stop is None:
            return (dx, dy), bound, None
        askew = self._askew(tick)
        velocity = turned(report.velocity[0], report.velocity[1], askew)
        stop = turned(report.stop[0], report.stop[1], askew)
        return (dx, dy), bound, BaseMotion(velocity, report.heading + askew, stop)

    def obeyed(self, velocity: Vector, tick: int) -> Vector:
        """What the base makes of a commanded velocity, which it takes to be in its own frame; a point has no
        such frame, and its filter counts on that, whatever its odometry is."""
        if not self._has_heading:
            return velocity
        return turned(velocity[0], velocity[1], -self._askew(tick))

    def _askew(self, tick: int) -> float:
        """The error of its direction, rad."""
        return self._heading * (2.0 * self._draws.at(tick)[2] - 1.0) if self._heading > 0.0 else 0.0
