"""Single integrators with a speed limit and imperfect actuation: b' = v + |v| w, held for one tick."""

from __future__ import annotations

import math
from collections.abc import Mapping

from protocol.draws import Purpose
from protocol.messages import Vector
from protocol.scenario.model import Scenario
from world.plants.disturbance import Uniforms, truncated_normal

STANDING: Vector = (0.0, 0.0)


def limited(velocity: Vector, speed: float) -> Vector:
    """The nearest velocity within the speed limit: `math.hypot` of it is at most `speed`, exactly.

    A velocity too large for its length to be a number is none: the robot stands still.
    """
    x, y = velocity
    length = math.hypot(x, y)
    if length <= speed:
        return velocity
    if not math.isfinite(length):
        return STANDING
    scale = speed / length
    while math.hypot(x * scale, y * scale) > speed:  # rounding, by a last place or two
        scale = math.nextafter(scale, 0.0)
    return (x * scale, y * scale)


class Actuation:
    """Turns the velocity that a robot asks for into what its disk really does during a tick."""

    def __init__(self, scenario: Scenario) -> None:
        self._step = scenario.time.step
        self._speed = scenario.control.speed
        self._noise = scenario.actuation.noise
        self._bound = scenario.actuation.bound
        self._draws = {robot: Uniforms(scenario.seed, Purpose.ACTUATION, robot, 2) for robot in scenario.ids}

    def recast(self, scenario: Scenario) -> None:
        """Robots came and went."""
        for robot in scenario.ids:
            self._draws.setdefault(robot, Uniforms(scenario.seed, Purpose.ACTUATION, robot, 2))

    def displacement(self, velocity: Vector, robot: int, tick: int) -> Vector:
        """Displacement during `tick`, m.

        The velocity is limited before and after the disturbance. The second time changes nothing
        about |executed - v| <= bound |v|, because v itself is within the limit and a projection
        onto a convex set brings no two points further apart.
        """
        x, y = limited(velocity, self._speed)
        if self._noise > 0.0 and (x != 0.0 or y != 0.0):
            radial, angular = self._draws[robot].at(tick)
            wx, wy = truncated_normal(radial, angular, self._noise, self._bound)
            length = math.hypot(x, y)
            x, y = limited((x + length * wx, y + length * wy), self._speed)
        return (x * self._step, y * self._step)


class Bodies:
    """Where every disk really is.

    Attributes:
        ids: robot ids in increasing order; all lists below are in this order.
        positions: centres, m.
        displacements: what each did during the last tick, m; added to the old position it gave the new one.
        lengths: path length of each so far, m.
    """

    def __init__(self, scenario: Scenario) -> None:
        self.ids = scenario.ids
        self.positions: list[Vector] = [scenario.spec(robot).start for robot in self.ids]
        self.displacements: list[Vector] = [STANDING] * len(self.ids)
        self.lengths = [0.0] * len(self.ids)
        self._actuation = Actuation(scenario)

    def recast(self, scenario: Scenario) -> None:
        """Robots came and went: a new one is at its start; of one that left nothing is kept."""
        each = zip(self.positions, self.displacements, self.lengths, strict=True)
        known = dict(zip(self.ids, each, strict=True))
        self.ids = scenario.ids
        kept = [known.get(robot, (scenario.spec(robot).start, STANDING, 0.0)) for robot in self.ids]
        self.positions = [position for position, _, _ in kept]
        self.displacements = [displacement for _, displacement, _ in kept]
        self.lengths = [length for _, _, length in kept]
        self._actuation.recast(scenario)

    def move(self, commands: Mapping[int, Vector], tick: int) -> None:
        """All move at once for one tick: x += executed velocity times step; without a command, none."""
        for index, robot in enumerate(self.ids):
            velocity = commands.get(robot)
            if velocity is None:
                self.displacements[index] = STANDING
                continue
            dx, dy = self._actuation.displacement(velocity, robot, tick)
            x, y = self.positions[index]
            self.positions[index] = (x + dx, y + dy)
            self.displacements[index] = (dx, dy)
            self.lengths[index] += math.hypot(dx, dy)
