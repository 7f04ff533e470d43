"""Formulas: points are single integrators with a speed limit and imperfect actuation, b' = v + |v| w, held
for one tick; other bodies follow their nominal path within their tolerance (`protocol.bodies`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from protocol.bodies.kinematics import Arc, Kinematics, Motion, chord, steps_of
from protocol.bodies.sweep import Tolerance
from protocol.draws import Purpose, Uniforms
from protocol.messages import STILL, Vector
from protocol.scenario.body import PRESETS
from protocol.scenario.model import RobotSpec, Scenario
from world.plants.plant import BaseReport, UnitDisk, truncated_normal


def limited(velocity: Vector, speed: float) -> Vector:
    """The nearest velocity within the speed limit: `math.hypot` of it is at most `speed`, exactly.

    A velocity of infinite length becomes zero.
    """
    x, y = velocity
    length = math.hypot(x, y)
    if length <= speed:
        return velocity
    if not math.isfinite(length):
        return STILL
    scale = speed / length
    while math.hypot(x * scale, y * scale) > speed:  # rounding, by a last place or two
        scale = math.nextafter(scale, 0.0)
    return (x * scale, y * scale)


class SimulatedPoint:
    """The base of a point, which executes velocities at once, with random errors."""

    stands = True

    def __init__(self, scenario: Scenario, robot: int) -> None:
        self._step, self._speed = scenario.time.step, scenario.control.speed
        self._noise, self._bound = scenario.actuation.noise, scenario.actuation.bound
        self._draws = Uniforms(scenario.seed, Purpose.ACTUATION, robot, 2)

    def report(self, displacement: Vector) -> BaseReport:
        return BaseReport(displacement, math.hypot(*displacement))

    def move(self, velocity: Vector | None, tick: int) -> list[Vector]:
        """Displacement during `tick`, m, even in time; without a command a point stands.

        The velocity is limited before and after the disturbance. The second time changes nothing
        about |executed - v| <= bound |v|, because v itself is within the limit and a projection
        onto a convex set brings no two points further apart.
        """
        x, y = limited(velocity or STILL, self._speed)
        if self._noise > 0.0 and (x != 0.0 or y != 0.0):
            radial, angular = self._draws.at(tick)
            wx, wy = truncated_normal(radial, angular, self._noise, self._bound)
            length = math.hypot(x, y)
            x, y = limited((x + length * wx, y + length * wy), self._speed)
        return [(x * self._step, y * self._step)]


class SimulatedBase:
    """One robot's base. From a command on, and from the first part of its tick, its error is one vector of
    the unit disk (`errors`) times its tolerance.
    """

    def __init__(
        self, kinematics: Kinematics, tolerance: Tolerance, motion: Motion, errors: UnitDisk
    ) -> None:
        self.motion = motion  # at the start of the next tick
        self._gone = 0.0  # m, in the last tick
        self._kinematics, self._tolerance, self._errors = kinematics, tolerance, errors
        self._error = self._off = STILL  # vector of the unit disk, and the resulting error, m
        self._way = self._slip = 0.0  # m, since the last command

    @property
    def stands(self) -> bool:
        return self.motion.stands

    def report(self, displacement: Vector) -> BaseReport:
        motion = self.motion
        stop = self._kinematics.stop(motion)
        return BaseReport(displacement, self._gone, motion.velocity, motion.heading, stop)

    def move(self, velocity: Vector | None, tick: int) -> list[Vector]:
        """Advance a tick with a commanded velocity (m/s) or none; displacement of each part, m."""
        heading = self.motion.heading
        steps = []
        for arc in self._arcs(velocity, tick):
            turn = self._kinematics.turn(arc)
            dx, dy = chord(arc, turn, heading)
            heading += turn
            self._way += math.hypot(arc.ahead, arc.aside) * arc.duration
            size = self._tolerance.error * self._way + self._slip
            bx, by = self._off
            ex, ey = self._off = size * self._error[0], size * self._error[1]
            steps.append((dx + ex - bx, dy + ey - by))
        self._gone = math.fsum(math.hypot(*step) for step in steps)
        return steps

    def _arcs(self, velocity: Vector | None, tick: int) -> list[Arc]:
        kinematics, motion = self._kinematics, self.motion
        if velocity is None or velocity == STILL:
            arcs, self.motion = kinematics.unled(motion, ordered=velocity is not None)
            return arcs
        to = kinematics.limited(motion, velocity)
        self._error, self._off = self._errors.at(tick), STILL
        self._way, self._slip = 0.0, self._tolerance.slip(motion, to)
        self.motion = kinematics.driven(motion, *to)
        arcs = kinematics.drive(motion, *to)
        return arcs if len(arcs) > 1 else [Arc(*to, arcs[0].duration / kinematics.steps)] * kinematics.steps


def simulated_base(scenario: Scenario, robot: int) -> SimulatedPoint | SimulatedBase:
    """The base of one robot of a scenario, with random errors."""
    body = scenario.body_of(robot)
    if body.ideal:
        return SimulatedPoint(scenario, robot)
    return SimulatedBase(
        Kinematics(body, scenario.time.step),
        Tolerance(body, scenario.actuation.bound),
        Motion(scenario.spec(robot).heading),
        UnitDisk(scenario.seed, Purpose.ACTUATION, robot),
    )


class Integrator:
    """True positions of all disks, by formulas: a `world.plants.plant.Plant`."""

    slips = False
    fixed = ""

    def __init__(self, scenario: Scenario, parts: int = 1) -> None:
        self._default = scenario.body
        self.ids: tuple[int, ...] = ()
        self.positions: list[Vector] = []
        self.displacements: list[Vector] = []  # of each disk during the last tick, m
        self.lengths: list[float] = []
        self.between: list[tuple[Vector, ...]] = []
        self._bases: dict[int, SimulatedPoint | SimulatedBase] = {}  # by robot
        self.set_fleet(scenario)
        is_of_points = all(scenario.body_of(robot).ideal for robot in scenario.ids)
        self.parts = parts if is_of_points else steps_of(scenario.time.step)

    def report(self, index: int) -> BaseReport:
        return self._bases[self.ids[index]].report(self.displacements[index])

    def stands(self, index: int) -> bool:
        return self._bases[self.ids[index]].stands

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
        kept = [known.get(robot, (scenario.spec(robot).start, STILL, 0.0)) for robot in self.ids]
        self.positions = [position for position, _, _ in kept]
        self.displacements = [displacement for _, displacement, _ in kept]
        self.lengths = [length for _, _, length in kept]
        self._bases = {robot: self._bases.get(robot) or simulated_base(scenario, robot) for robot in self.ids}

    def move(self, commands: Mapping[int, Vector], tick: int) -> None:
        """Move all disks for one tick: x += executed velocity times step."""
        ends = []
        for index, (robot, base) in enumerate(self._bases.items()):
            velocity = commands.get(robot)
            ends.append(self._advance(index, base.move(velocity, tick)))
        self.between = list(zip(*ends, strict=True))[:-1]

    def _advance(self, index: int, steps: list[Vector]) -> list[Vector]:
        """Move a disk by the steps of a tick, one of them evenly; its places at the ends of all parts."""
        x, y = bx, by = self.positions[index]
        places = []
        for dx, dy in steps:
            x, y = x + dx, y + dy
            places.append((x, y))
            self.lengths[index] += math.hypot(dx, dy)
        self.positions[index] = (x, y)
        self.displacements[index] = steps[0] if len(steps) == 1 else (x - bx, y - by)
        if len(steps) < self.parts:
            (dx, dy), shares = steps[0], [part / self.parts for part in range(1, self.parts)]
            places = [(bx + share * dx, by + share * dy) for share in shares] + places
        return places
