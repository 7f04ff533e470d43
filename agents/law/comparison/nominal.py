"""What a law without a navigation function wants before it looks at others: straight to the goal, or along
the shortest way to it among things."""

from __future__ import annotations

import math
from collections.abc import Sequence

from agents.law.obstacles import Attraction
from protocol.draws import Purpose, generator
from protocol.geometry import Shape
from protocol.messages import Vector
from protocol.scenario.model import Scenario

_HELD = 1.0  # s that a random part stays as it is: drawn anew every tick it would average out


class Nominal:
    """Straight to the goal at the speed limit, in one period at the end, off by a random part.

    Without that part symmetric encounters never end: both laws are known to need it.
    """

    def __init__(self, scenario: Scenario, robot: int, noise: float) -> None:
        """`noise`: largest random velocity, as a fraction of the speed limit; none at the goal."""
        self._robot, self._seed = robot, scenario.seed
        self._speed, self._period = scenario.control.speed, scenario.time.step
        self._held = max(1, scenario.ticks(_HELD))
        self._tolerance, self._noise = scenario.time.tolerance, noise
        self._attraction = Attraction(
            scenario.workspace.shape, scenario.spec(robot).radius, alone=len(scenario.robots) == 1
        )

    def velocity(self, position: Vector, goal: Vector, tick: int, things: Sequence[Shape] = ()) -> Vector:
        """m/s, at most the speed limit and the random part."""
        goal = self._attraction.aim(position, goal, things)
        dx, dy = goal[0] - position[0], goal[1] - position[1]
        away = math.hypot(dx, dy)
        if away <= 0.5 * self._tolerance:
            return 0.0, 0.0
        rate = min(self._speed / away, 1.0 / self._period)
        draw = generator(self._seed, Purpose.CONTROL, self._robot, tick // self._held)
        angle, size = math.tau * draw.random(), self._noise * self._speed * draw.random()
        return rate * dx + size * math.cos(angle), rate * dy + size * math.sin(angle)
