"""What a scenario says that carries a robot."""

from __future__ import annotations

from agents.bodies.body import Body
from agents.bodies.inertial import InertialBody
from agents.bodies.point import PointBody
from protocol.bodies.base import Base
from protocol.bodies.sweep import Miss
from protocol.scenario.model import Scenario


def body_of(scenario: Scenario, robot: int) -> Body:
    """The body of one robot."""
    body, speed, period = scenario.body_of(robot), scenario.control.speed, scenario.time.step
    if body.ideal:
        return PointBody(speed, period, scenario.actuation.bound)
    return InertialBody(
        Base(body, period),
        speed,
        Miss(body.error + scenario.actuation.bound, body.lag, body.play),
        scenario.sensing_of(robot).heading,
    )
