"""Formulas: points are single integrators with a speed limit and imperfect actuation, b' = v + |v| w, held
for one tick; other bodies move as `protocol.bodies` says."""

from __future__ import annotations

import math
from collections.abc import Mapping

from mypy_extensions import mypyc_attr

from protocol.bodies.base import STEPS
from protocol.draws import Purpose
from protocol.messages import Vector
from protocol.scenario.body import PRESETS
from protocol.scenario.model import RobotSpec, Scenario
from world.plants.base import SimulatedBase
from world.plants.disturbance import Uniforms, truncated_normal
from world.plants.plant import Report

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


@mypyc_attr(allow_interpreted_subclasses=True)
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


@mypyc_attr(allow_interpreted_subclasses=True)
class Integrator:
    """Where every disk really is, by formulas; see `world.plants.plant.Plant`.

    Attributes:
        ids, positions, lengths, parts, between, slips: see there.
        displacements: what each did during the last tick, m; added to the old position it gave the new one.
    """

    slips = False
    fixed = ""

    def __init__(self, scenario: Scenario) -> None:
        self.ids = scenario.ids
        self._default = scenario.body
        self.positions: list[Vector] = [scenario.spec(robot).start for robot in self.ids]
        self.displacements: list[Vector] = [STANDING] * len(self.ids)
        self.lengths = [0.0] * len(self.ids)
        self.between: list[tuple[Vector, ...]] = []
        self._actuation = Actuation(scenario)
        self._based = {
            robot: SimulatedBase(scenario, robot) for robot in self.ids if not scenario.body_of(robot).ideal
        }
        self._bases = self._by_index()
        self.parts = STEPS if self._bases else 1

    def _by_index(self) -> dict[int, SimulatedBase]:
        return {self.ids.index(robot): base for robot, base in self._based.items()}

    def report(self, index: int) -> Report:
        """See `world.plants.plant.Plant`."""
        base = self._bases.get(index)
        if base is None:
            return Report(self.displacements[index])
        motion = base.motion
        return Report(self.displacements[index], motion.velocity, motion.heading, base.stop)

    def stands(self, index: int) -> bool:
        """See `world.plants.plant.Plant`."""
        base = self._bases.get(index)
        return base is None or base.motion.stands

    def touched(self) -> list[tuple[int, int]]:
        """None: formulas know of no contact."""
        return []

    def refusal(self, spec: RobotSpec) -> str:
        """See `world.plants.plant.Plant`."""
        body = self._default if spec.body is None else spec.body
        if self.parts == 1 and not (PRESETS[body] if isinstance(body, str) else body).ideal:
            return f"robot {spec.id}: a fleet of points takes in points only"
        return ""

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
        self._based = {
            robot: self._based.get(robot) or SimulatedBase(scenario, robot)
            for robot in self.ids
            if not scenario.body_of(robot).ideal
        }
        self._bases = self._by_index()

    def move(self, commands: Mapping[int, Vector], tick: int) -> None:
        """All move at once for one tick: x += executed velocity times step; a point without one stands."""
        before = tuple(self.positions)
        parts: dict[int, list[Vector]] = {}
        for index, robot in enumerate(self.ids):
            velocity = commands.get(robot)
            base = self._bases.get(index)
            if base is not None:
                parts[index] = self._move_base(index, base.move(velocity, tick))
            elif velocity is None:
                self.displacements[index] = STANDING
            else:
                self._move_point(index, *self._actuation.displacement(velocity, robot, tick))
        if self.parts > 1:
            self.between = self._between(before, parts)

    def _move_point(self, index: int, dx: float, dy: float) -> None:
        x, y = self.positions[index]
        self.positions[index] = (x + dx, y + dy)
        self.displacements[index] = (dx, dy)
        self.lengths[index] += math.hypot(dx, dy)

    def _move_base(self, index: int, steps: list[Vector]) -> list[Vector]:
        """Go through a tick in parts; where each of them ends."""
        x, y = before = self.positions[index]
        places = []
        for dx, dy in steps:
            x, y = x + dx, y + dy
            places.append((x, y))
            self.lengths[index] += math.hypot(dx, dy)
        self.positions[index] = (x, y)
        self.displacements[index] = (x - before[0], y - before[1])
        return places

    def _between(
        self, before: tuple[Vector, ...], parts: Mapping[int, list[Vector]]
    ) -> list[tuple[Vector, ...]]:
        """All disks at the ends of the parts of a tick but the last; points move evenly."""
        between = []
        for part in range(STEPS - 1):
            share = (part + 1) / STEPS
            between.append(
                tuple(
                    parts[index][part]
                    if index in parts
                    else (x + share * self.displacements[index][0], y + share * self.displacements[index][1])
                    for index, (x, y) in enumerate(before)
                )
            )
        return between
