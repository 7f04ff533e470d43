"""A law from outside the fleet: each robot wants what a planner, a person or a policy last told it."""

from __future__ import annotations

import math

from agents.law.api import Law, View
from protocol.messages import Vector
from protocol.scenario.model import Scenario


class ExternalLaw(Law):
    """The newest wish, at most the speed limit; none once it is older than `control.lifetime`."""

    def __init__(self, scenario: Scenario, robot: int) -> None:
        del robot
        self._speed, self._lifetime = scenario.control.speed, scenario.ticks(scenario.control.lifetime)
        self._wish: Vector = (0.0, 0.0)
        self._until = -1  # tick up to which it counts

    def tell(self, wish: Vector, tick: int) -> None:
        """Take a wish, m/s, that came during `tick`."""
        excess = max(1.0, math.hypot(*wish) / self._speed)
        self._wish = wish[0] / excess, wish[1] / excess
        self._until = tick + self._lifetime

    def velocity(self, view: View) -> Vector:
        """Desired velocity, m/s."""
        return self._wish if view.tick <= self._until else (0.0, 0.0)
