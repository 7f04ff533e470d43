"""Formulas: points are single integrators with a speed limit and imperfect actuation, b' = v + |v| w, held
for one tick; other bodies follow their nominal path within their tolerance (`protocol.bodies`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Protocol

from protocol.bodies.kinematics import Arc, Kinematics, Motion, chord, steps_of, turned
from protocol.bodies.sweep import Tolerance
from protocol.draws import Purpose
from protocol.messages import Vector
from protocol.scenario.body import PRESETS
from protocol.scenario.model import RobotSpec, Scenario
from world.plants.plant import BaseReport, Uniforms, UnitDisk, truncated_normal

STANDING: Vector = (0.0, 0.0)


def limited(velocity: Vector, speed: float) -> Vector:
    """The nearest velocity within the speed limit: `math.hypot` of it is at most `speed`, exactly.

    A velocity of infinite length becomes zero.
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


class Actuators:
    """Computes the executed displacement for a commanded velocity."""

    def __init__(self, scenario: Scenario) -> None:
        self._step = scenario.time.step
        self._speed = scenario.control.speed
        self._noise = scenario.actuation.noise
        self._bound = scenario.actuation.bound
        self._draws = {robot: Uniforms(scenario.seed, Purpose.ACTUATION, robot, 2) for robot in scenario.ids}

    def set_fleet(self, scenario: Scenario) -> None:
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


class Errors(Protocol):
    """The direction and size of a base's error, as a vector in the unit disk."""

    def at(self, tick: int) -> Vector:
        """The error of a command of `tick`."""
        ...


class SimulatedBase:
    """One robot's base. From a command on, and from the first part of its tick, its error is one vector of
    the unit disk (`errors`) times its tolerance.

    Attributes:
        motion: at the start of the next tick.
        way: displacement in the last tick, m.
    """

    def __init__(self, kinematics: Kinematics, tolerance: Tolerance, motion: Motion, errors: Errors) -> None:
        self.motion, self.way = motion, 0.0
        self._kinematics, self._tolerance, self._errors = kinematics, tolerance, errors
        self._error = self._off = STANDING  # vector of the unit disk, and the resulting error, m
        self._way = self._slip = 0.0  # m, since the last command

    @property
    def stop(self) -> Vector:
        """Displacement to the stop without further commands, m."""
        arc = self._kinematics.halt(self.motion)
        dx, dy = chord(arc, self._kinematics.turn(arc))
        return turned(dx, dy, self.motion.heading)

    def move(self, velocity: Vector | None, tick: int) -> list[Vector]:
        """Advance a tick with a commanded velocity (m/s) or none; displacement of each part, m."""
        heading = self.motion.heading
        steps = []
        for arc in self._arcs(velocity, tick):
            turn = self._kinematics.turn(arc)
            cx, cy = chord(arc, turn)
            dx, dy = turned(cx, cy, heading)
            heading += turn
            self._way += math.hypot(arc.ahead, arc.aside) * arc.duration
            size = self._tolerance.error * self._way + self._slip
            bx, by = self._off
            ex, ey = self._off = size * self._error[0], size * self._error[1]
            steps.append((dx + ex - bx, dy + ey - by))
        self.way = math.fsum(math.hypot(*step) for step in steps)
        return steps

    def _arcs(self, velocity: Vector | None, tick: int) -> list[Arc]:
        kinematics, motion = self._kinematics, self.motion
        part = kinematics.period / kinematics.steps
        if velocity is None or (velocity[0] == 0.0 and velocity[1] == 0.0):
            arcs = []
            coasting = motion if velocity is None else kinematics.braking(motion)
            for _ in range(kinematics.steps):
                arcs.append(kinematics.coast(coasting, part))
                coasting = kinematics.coasted(coasting, part)
            self.motion = coasting
            return arcs
        to = kinematics.limited(motion, velocity)
        self._error, self._off = self._errors.at(tick), STANDING
        self._way, self._slip = 0.0, self._tolerance.slip(motion, to)
        self.motion = kinematics.driven(motion, *to)
        arcs = kinematics.drive(motion, *to)
        return arcs if len(arcs) > 1 else [Arc(*to, part)] * kinematics.steps


def simulated_base(scenario: Scenario, robot: int) -> SimulatedBase:
    """The base of one robot of a scenario, with random errors."""
    body = scenario.body_of(robot)
    return SimulatedBase(
        Kinematics(body, scenario.time.step),
        Tolerance(body, scenario.actuation.bound),
        Motion(scenario.spec(robot).heading),
        UnitDisk(scenario.seed, Purpose.ACTUATION, robot),
    )


class Integrator:
    """True positions of all disks, by formulas: a `world.plants.plant.Plant`.

    Attributes:
        displacements: of each disk during the last tick, m.
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
        self._actuation = Actuators(scenario)
        self._bases: dict[int, SimulatedBase] = {}  # by robot; a point has none
        self._set_bases(scenario)
        self.parts = steps_of(scenario.time.step) if self._bases else 1

    def _set_bases(self, scenario: Scenario) -> None:
        self._bases = {
            robot: self._bases.get(robot) or simulated_base(scenario, robot)
            for robot in self.ids
            if not scenario.body_of(robot).ideal
        }

    def report(self, index: int) -> BaseReport:
        base = self._bases.get(self.ids[index])
        if base is None:
            displacement = self.displacements[index]
            return BaseReport(displacement, math.hypot(*displacement))
        motion = base.motion
        return BaseReport(self.displacements[index], base.way, motion.velocity, motion.heading, base.stop)

    def stands(self, index: int) -> bool:
        base = self._bases.get(self.ids[index])
        return base is None or base.motion.stands

    def touched(self) -> list[tuple[int, int]]:
        return []

    def refusal(self, spec: RobotSpec) -> str:
        body = self._default if spec.body is None else spec.body
        if self.parts == 1 and not (PRESETS[body] if isinstance(body, str) else body).ideal:
            return f"robot {spec.id}: a fleet of points takes in points only"
        return ""

    def set_fleet(self, scenario: Scenario) -> None:
        """Set the robots; a new one is at its start, removed ones are forgotten."""
        each = zip(self.positions, self.displacements, self.lengths, strict=True)
        known = dict(zip(self.ids, each, strict=True))
        self.ids = scenario.ids
        kept = [known.get(robot, (scenario.spec(robot).start, STANDING, 0.0)) for robot in self.ids]
        self.positions = [position for position, _, _ in kept]
        self.displacements = [displacement for _, displacement, _ in kept]
        self.lengths = [length for _, _, length in kept]
        self._actuation.set_fleet(scenario)
        self._set_bases(scenario)

    def move(self, commands: Mapping[int, Vector], tick: int) -> None:
        """Move all disks for one tick: x += executed velocity times step; without a command, points stand."""
        before = tuple(self.positions)
        parts: dict[int, list[Vector]] = {}
        for index, robot in enumerate(self.ids):
            velocity = commands.get(robot)
            base = self._bases.get(robot)
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
        """Advance a base by a tick; returns the ends of the parts."""
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
        """All disks at the ends of all parts of a tick but the last; points move evenly."""
        between = []
        for part in range(self.parts - 1):
            share = (part + 1) / self.parts
            between.append(
                tuple(
                    parts[index][part]
                    if index in parts
                    else (x + share * self.displacements[index][0], y + share * self.displacements[index][1])
                    for index, (x, y) in enumerate(before)
                )
            )
        return between
