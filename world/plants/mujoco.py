"""A fleet of two-wheeled robots in MuJoCo: servos with lag, wheels with slip, hulls with contact forces.

Each robot is a hull, two driven wheels and two casters; for the elements of the model see
https://mujoco.readthedocs.io/en/stable/XMLreference.html. Around its control point is its disk, a cylinder
that exerts no force, but whose contacts the engine reports: with `margin` -1 and `gap` 1 a contact is
detected as soon as two overlap, and is never passed to the solver.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any
from xml.etree.ElementTree import Element, SubElement, tostring

import mujoco

from protocol.bodies.kinematics import Arc, Kinematics, Motion, chord, steps_of
from protocol.errors import UsageError
from protocol.messages import Vector
from protocol.scenario.body import Body
from protocol.scenario.model import RobotSpec, Scenario
from world.plants.plant import BaseReport

_STEP = 0.002  # s, longest time step of the engine
_WHEEL = 0.2  # of the track: radius of a wheel
_DENSITY = 32.0  # kg/m^2 of a hull: a disk of radius 0.1 m weighs a kilogram
_LAG = 0.015  # s, time constant of a wheel's servo; its gain must stay small for the wheel's inertia
_INTEGRAL = 0.5  # of the gain in a lag: integral part of a servo, damped by 0.7; friction leaves no error
_PUSH = 3.0  # m/s^2, largest acceleration by both servos
_COLOURS = (
    "0.12 0.47 0.71",
    "1.00 0.50 0.05",
    "0.17 0.63 0.17",
    "0.84 0.15 0.16",
    "0.58 0.40 0.74",
    "0.55 0.34 0.29",
)
_REST = 1e-4  # m/s of a wheel's rim below which a braking base stands
_SETTLING = 0.2  # s, initial time for wheels and casters to come to rest on the floor


class Physics:
    """Implements `world.plants.plant.Plant`. Odometry is that of the wheels' encoders; headings are true."""

    slips = True
    fixed = "robots in MuJoCo cannot be added or removed during a run: start another run"

    def __init__(self, scenario: Scenario) -> None:
        self._engine: Any = mujoco
        period = scenario.time.step
        self.parts = steps_of(period)
        self._substeps = math.ceil(period / (self.parts * _STEP) - 1e-9)
        timestep = period / (self.parts * self._substeps)
        self._model = self._engine.MjModel.from_xml_string(_model(scenario, timestep))
        self._data = self._engine.MjData(self._model)
        self.ids = scenario.ids
        self.lengths = [0.0] * len(self.ids)
        self.between: list[tuple[Vector, ...]] = []
        self._robots = [
            _Wheeled(self._model, self._data, robot, scenario.body_of(robot), period) for robot in self.ids
        ]
        self._disks = {self._model.geom(f"disk {robot}").id: robot for robot in self.ids}
        self._step(round(_SETTLING / timestep))
        self.positions: list[Vector] = [robot.place() for robot in self._robots]
        self._touched: set[tuple[int, int]] = set()
        for robot in self._robots:
            robot.begin()

    def move(self, commands: Mapping[int, Vector], tick: int) -> None:  # noqa: ARG002
        """No number is random here."""
        for robot, driven in zip(self.ids, self._robots, strict=True):
            driven.plan(commands.get(robot))
        self._touched.clear()
        self.between = []
        for part in range(self.parts):
            for driven in self._robots:
                driven.actuate(part)
            self._step(self._substeps)
            for driven in self._robots:
                driven.read_encoders()
            self._touch()
            self._arrive(part == self.parts - 1)
        for driven in self._robots:
            driven.begin()

    def refusal(self, spec: RobotSpec) -> str:  # noqa: ARG002
        return self.fixed

    def set_fleet(self, scenario: Scenario) -> None:  # noqa: ARG002
        raise UsageError(self.fixed)

    def report(self, index: int) -> BaseReport:
        return self._robots[index].report()

    def stands(self, index: int) -> bool:
        return self._robots[index].motion.stands

    def touched(self) -> list[tuple[int, int]]:
        return sorted(self._touched)

    def _step(self, count: int) -> None:
        self._engine.mj_step(self._model, self._data, count)
        self._engine.mj_kinematics(self._model, self._data)  # `mj_step` does not update derived positions

    def _touch(self) -> None:
        contact = self._data.contact
        if self._data.ncon == 0:
            return
        for one, other in contact.geom[:, :2].tolist():
            if one in self._disks and other in self._disks:
                first, second = sorted((self._disks[one], self._disks[other]))
                self._touched.add((first, second))

    def _arrive(self, last: bool) -> None:
        places = [driven.place() for driven in self._robots]
        before = self.between[-1] if self.between else self.positions
        for index, (x, y) in enumerate(places):
            self.lengths[index] += math.hypot(x - before[index][0], y - before[index][1])
        if last:
            self.positions = places
        else:
            self.between.append(tuple(places))


class _Wheeled:
    """One robot: actuators and sensors of its base."""

    def __init__(self, model: Any, data: Any, robot: int, body: Body, period: float) -> None:
        self._kinematics, self._body, self._radius = Kinematics(body, period), body, _WHEEL * body.track
        self._site, self._frame = data.site(f"{robot}"), data.body(f"{robot}")
        self._control = data.ctrl
        self._wheels = [data.joint(f"{side} {robot}") for side in ("left", "right")]
        self._servos = [
            (model.actuator(f"{side} {robot}").id, model.actuator(f"{side} {robot} integral").id)
            for side in ("left", "right")
        ]
        # At the beginning of the tick: the nominal motion in the true direction, or after its end the
        # remaining motion of the wheels.
        self.motion = self._next = Motion(0.0)
        self._arcs: list[Arc] = []
        self._angles = [0.0, 0.0]
        self._odometry, self._way, self._turned = (0.0, 0.0), 0.0, 0.0
        self._moved = self._odometry, self._way  # in the tick before

    def place(self) -> Vector:
        """Position of the control point, m."""
        x, y, _ = self._site.xpos.tolist()
        return x, y

    def heading(self) -> float:
        """True direction, rad."""
        rotation = self._frame.xmat
        return math.atan2(rotation[3], rotation[0])

    def begin(self) -> None:
        """Begin a tick: encoders count from here, in the true direction."""
        motion, heading = self._next, self.heading()
        self.motion = Motion(heading, motion.ahead, motion.aside, motion.hold)
        if motion.stands:
            left, right = (self._radius * float(wheel.qvel[0]) for wheel in self._wheels)
            if max(abs(left), abs(right)) > _REST:
                aside = (right - left) / self._body.track * self._body.offset
                self.motion = Motion(heading, 0.5 * (left + right), aside)
        self._moved = self._odometry, self._way
        self._odometry, self._way, self._turned = (0.0, 0.0), 0.0, heading
        self._angles = [float(wheel.qpos[0]) for wheel in self._wheels]

    def plan(self, velocity: Vector | None) -> None:
        """Plan this tick, with a commanded velocity (m/s) or none."""
        kinematics = self._kinematics
        if velocity is not None and (velocity[0] != 0.0 or velocity[1] != 0.0):
            motion = self.motion
            to = kinematics.limited(motion, velocity)
            self._arcs, self._next = kinematics.drive(motion, *to), kinematics.driven(motion, *to)
            return
        part = kinematics.period / kinematics.steps
        arcs, self._next = kinematics.unled(self._next, ordered=velocity is not None)
        shares = [(arc, arc.duration / part) for arc in arcs]  # average shares of the velocities
        self._arcs = [Arc(share * arc.ahead, share * arc.aside, part) for arc, share in shares]

    def actuate(self, part: int) -> None:
        """Set the wheels' servos for a part of the tick."""
        arc = self._arcs[part]
        across = 0.5 * arc.aside * self._body.track / self._body.offset
        for servos, speed in zip(self._servos, (arc.ahead - across, arc.ahead + across), strict=True):
            for servo in servos:
                self._control[servo] = speed / self._radius

    def read_encoders(self) -> None:
        """Odometry by the rotation of the wheels."""
        left, right = (float(wheel.qpos[0]) for wheel in self._wheels)
        rolled_left = self._radius * (left - self._angles[0])
        rolled_right = self._radius * (right - self._angles[1])
        self._angles = [left, right]
        turn = (rolled_right - rolled_left) / self._body.track
        arc = Arc(0.5 * (rolled_left + rolled_right), turn * self._body.offset, 1.0)
        dx, dy = chord(arc, turn, self._turned)
        self._turned += turn
        self._odometry = (self._odometry[0] + dx, self._odometry[1] + dy)
        self._way += math.hypot(dx, dy)

    def report(self) -> BaseReport:
        (displacement, way), motion = self._moved, self.motion
        return BaseReport(displacement, way, motion.velocity, motion.heading, self._kinematics.stop(motion))


def _model(scenario: Scenario, timestep: float) -> str:
    """The XML of a scenario of robots with two wheels."""
    root = Element("mujoco", model=scenario.name)
    SubElement(
        root, "option", timestep=f"{timestep}", integrator="implicitfast", cone="elliptic", impratio="10"
    )
    visual = SubElement(root, "visual")
    SubElement(visual, "global", offwidth="1200", offheight="900")
    SubElement(visual, "headlight", ambient="0.5 0.5 0.5", diffuse="0.5 0.5 0.5")
    world = SubElement(root, "worldbody")
    SubElement(world, "light", pos="0 0 5", dir="0 0 -1", diffuse="0.4 0.4 0.4")
    size = 2.0 * scenario.workspace.shape.around.radius
    SubElement(world, "geom", name="floor", type="plane", size=f"{size} {size} 0.1", rgba="0.9 0.9 0.88 1")
    actuator = SubElement(root, "actuator")
    for spec in sorted(scenario.robots, key=lambda each: each.id):
        _robot(world, actuator, spec, scenario.body_of(spec.id))
    return tostring(root, encoding="unicode")


def _robot(world: Element, actuator: Element, spec: RobotSpec, body: Body) -> None:
    hull = spec.radius - body.offset if body.radius is None else body.radius
    wheel, mass = _WHEEL * body.track, _DENSITY * math.pi * hull * hull
    x = spec.start[0] - body.offset * math.cos(spec.heading)
    y = spec.start[1] - body.offset * math.sin(spec.heading)
    half = 0.5 * spec.heading
    name, colour = f"{spec.id}", _COLOURS[spec.id % len(_COLOURS)]
    base = SubElement(
        world, "body", name=name, pos=f"{x} {y} {wheel}", quat=f"{math.cos(half)} 0 0 {math.sin(half)}"
    )
    SubElement(base, "freejoint", name=name)
    # The weight lies low, between a caster in front and one behind: the body must not pitch when it brakes.
    SubElement(
        base, "geom", type="cylinder", size=f"{0.5 * hull} {0.3 * wheel}", pos=f"0 0 {-0.2 * wheel}",
        mass=f"{mass}", contype="0", conaffinity="0", rgba="0.2 0.2 0.2 1",
    )  # fmt: skip
    SubElement(
        base, "geom", name=f"hull {name}", type="cylinder", size=f"{hull} {wheel}", pos=f"0 0 {2.2 * wheel}",
        mass=f"{0.001 * mass}", rgba=f"{colour} 1",
    )  # fmt: skip
    for place in (0.75 * hull, -0.75 * hull):
        SubElement(
            base, "geom", type="sphere", size=f"{0.4 * wheel}", pos=f"{place} 0 {-0.59 * wheel}",
            mass=f"{0.01 * mass}", condim="1", friction="0 0 0", priority="1",
        )  # fmt: skip
    SubElement(
        base, "geom", name=f"disk {name}", type="cylinder", size=f"{spec.radius} {0.1 * wheel}",
        pos=f"{body.offset} 0 {-0.5 * wheel}", mass="0", contype="2", conaffinity="2", margin="-1", gap="1",
        rgba=f"{colour} 0.3",
    )  # fmt: skip
    SubElement(base, "site", name=name, pos=f"{body.offset} 0 0", size="0.001")
    gain, torque = 0.5 * mass * wheel * wheel / _LAG, 0.5 * _PUSH * mass * wheel
    for side, place in (("left", 0.5), ("right", -0.5)):
        joint = f"{side} {name}"
        _wheel(base, joint, place * body.track, wheel, 0.03 * mass, 0.1 * mass * wheel * wheel, torque)
        SubElement(actuator, "velocity", name=joint, joint=joint, kv=f"{gain}")
        SubElement(
            actuator, "intvelocity", name=f"{joint} integral", joint=joint, kp=f"{_INTEGRAL * gain / _LAG}"
        )


def _wheel(
    base: Element, name: str, place: float, radius: float, mass: float, inertia: float, torque: float
) -> None:
    body = SubElement(base, "body", pos=f"0 {place} 0")
    SubElement(
        body, "joint", name=name, type="hinge", axis="0 1 0", armature=f"{inertia}",
        actuatorfrcrange=f"{-torque} {torque}",
    )  # fmt: skip
    SubElement(
        body, "geom", type="cylinder", size=f"{radius} {0.25 * radius}", zaxis="0 1 0", mass=f"{mass}",
        friction="1.0 0.005 0.0001", rgba="0.1 0.1 0.1 1",
    )  # fmt: skip
