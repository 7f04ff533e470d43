"""Robots on wheels in MuJoCo: servos that lag, wheels that slip, hulls that push."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np

from protocol.bodies.base import STEPS, Arc, Base, Motion, chord, turned
from protocol.errors import UsageError
from protocol.messages import Vector
from protocol.scenario.body import Body
from protocol.scenario.model import RobotSpec, Scenario
from world.plants.mjcf import TIMESTEP, model, wheel_radius
from world.plants.plant import Report

_SETTLING = 0.2  # s, in which wheels and casters come to rest on the floor


class Physics:
    """See `world.plants.plant.Plant`. Odometry is that of the wheels' encoders; headings are true.

    Raises:
        UsageError: the control period cannot be parted into its time steps.
    """

    slips = True
    parts = STEPS
    fixed = "robots in MuJoCo are built once and for all: stop the run, and begin another"

    def __init__(self, scenario: Scenario) -> None:
        self._scenario = scenario
        self._engine: Any = mujoco
        self._model = self._engine.MjModel.from_xml_string(model(scenario))
        self._data = self._engine.MjData(self._model)
        self.ids = scenario.ids
        self.lengths = [0.0] * len(self.ids)
        self.between: list[tuple[Vector, ...]] = []
        self._substeps = _substeps(scenario.time.step)
        self._robots = [
            _Wheeled(self._model, self._data, robot, scenario.body_of(robot), scenario.time.step)
            for robot in self.ids
        ]
        self._disks = {self._model.geom(f"disk {robot}").id: robot for robot in self.ids}
        self._step(round(_SETTLING / TIMESTEP))
        self.positions: list[Vector] = [robot.place() for robot in self._robots]
        self._touched: set[tuple[int, int]] = set()
        for robot in self._robots:
            robot.begin()

    def __getstate__(self) -> dict[str, Any]:
        """The engine's part is what another one integrates on from to the last bit."""
        engine, what = self._engine, self._engine.mjtState.mjSTATE_INTEGRATION
        state = np.empty(engine.mj_stateSize(self._model, what))
        engine.mj_getState(self._model, self._data, state, what)
        own = {name: getattr(self, name) for name in ("lengths", "between", "positions", "_touched")}
        return {"scenario": self._scenario, "engine": state, "own": own, "robots": [*map(_own, self._robots)]}

    def __setstate__(self, state: Mapping[str, Any]) -> None:
        Physics.__init__(self, state["scenario"])
        vars(self).update(state["own"])
        for robot, own in zip(self._robots, state["robots"], strict=True):
            vars(robot).update(own)
        engine = self._engine
        engine.mj_setState(self._model, self._data, state["engine"], engine.mjtState.mjSTATE_INTEGRATION)
        engine.mj_kinematics(self._model, self._data)

    def move(self, commands: Mapping[int, Vector], tick: int) -> None:  # noqa: ARG002
        """See `world.plants.plant.Plant`; no number is random here."""
        for robot, driven in zip(self.ids, self._robots, strict=True):
            driven.plan(commands.get(robot))
        self._touched.clear()
        self.between = []
        for part in range(STEPS):
            for driven in self._robots:
                driven.actuate(part)
            self._step(self._substeps)
            for driven in self._robots:
                driven.read_encoders()
            self._touch()
            self._arrive(part == STEPS - 1)
        for driven in self._robots:
            driven.begin()

    def refusal(self, spec: RobotSpec) -> str:  # noqa: ARG002
        """See `world.plants.plant.Plant`."""
        return self.fixed

    def recast(self, scenario: Scenario) -> None:  # noqa: ARG002
        """See `world.plants.plant.Plant`."""
        raise UsageError(self.fixed)

    def report(self, index: int) -> Report:
        """See `world.plants.plant.Plant`."""
        return self._robots[index].report()

    def stands(self, index: int) -> bool:
        """See `world.plants.plant.Plant`."""
        return self._robots[index].motion.stands

    def touched(self) -> list[tuple[int, int]]:
        """See `world.plants.plant.Plant`."""
        return sorted(self._touched)

    def _step(self, count: int) -> None:
        self._engine.mj_step(self._model, self._data, count)
        self._engine.mj_kinematics(self._model, self._data)  # `mj_step` does not say where it led to

    def _touch(self) -> None:
        """Take note of disks in contact."""
        contact = self._data.contact
        if self._data.ncon == 0:
            return
        for one, other in contact.geom[:, :2].tolist():
            if one in self._disks and other in self._disks:
                first, second = sorted((self._disks[one], self._disks[other]))
                self._touched.add((first, second))

    def _arrive(self, last: bool) -> None:
        """Take note of where the disks are."""
        places = [driven.place() for driven in self._robots]
        before = self.between[-1] if self.between else self.positions
        for index, (x, y) in enumerate(places):
            self.lengths[index] += math.hypot(x - before[index][0], y - before[index][1])
        if last:
            self.positions = places
        else:
            self.between.append(tuple(places))


def _own(robot: _Wheeled) -> dict[str, Any]:
    """What a robot's base knows that the engine does not."""
    own = ("motion", "_arcs", "_angles", "_moved", "_odometry", "_turned", "_next")
    return {name: getattr(robot, name) for name in own}


class _Wheeled:
    """One robot: what its base makes of commands, and what its sensors say.

    Attributes:
        motion: what the base means to do, in the true direction.
    """

    def __init__(self, model: Any, data: Any, robot: int, body: Body, period: float) -> None:
        self._base, self._body, self._radius = Base(body, period), body, wheel_radius(body)
        self._site, self._frame = data.site(f"{robot}"), data.body(f"{robot}")
        self._control = data.ctrl
        self._wheels = [data.joint(f"{side} {robot}") for side in ("left", "right")]
        self._servos = [model.actuator(f"{side} {robot}").id for side in ("left", "right")]
        self.motion = Motion(0.0)
        self._arcs: list[Arc] = []
        self._angles = [0.0, 0.0]
        self._moved = (0.0, 0.0)
        self._odometry, self._turned = (0.0, 0.0), 0.0
        self._next = self.motion

    def place(self) -> Vector:
        """Where the control point is, m."""
        x, y, _ = self._site.xpos.tolist()
        return x, y

    def heading(self) -> float:
        """True direction, rad."""
        rotation = self._frame.xmat
        return math.atan2(rotation[3], rotation[0])

    def begin(self) -> None:
        """A tick begins: encoders count from here, in the true direction."""
        motion, heading = self._next, self.heading()
        self.motion = Motion(heading, motion.ahead, motion.aside, motion.hold)
        self._moved, self._odometry, self._turned = self._odometry, (0.0, 0.0), heading
        self._angles = [float(wheel.qpos[0]) for wheel in self._wheels]

    def plan(self, velocity: Vector | None) -> None:
        """What to do in this tick, with a commanded velocity (m/s) or none."""
        base, motion = self._base, self.motion
        if velocity is not None and (velocity[0] != 0.0 or velocity[1] != 0.0):
            ahead, aside = base.limited(motion, velocity)
            self._arcs, self._next = base.drive(motion, ahead, aside), base.driven(motion, ahead, aside)
            return
        part = base.period / STEPS
        coasting = motion if velocity is None else base.braking(motion)
        self._arcs = []
        for _ in range(STEPS):
            arc = base.coast(coasting, part)
            share = arc.duration / part  # of its velocity, on average
            self._arcs.append(Arc(share * arc.ahead, share * arc.aside, part))
            coasting = base.coasted(coasting, part)
        self._next = coasting

    def actuate(self, part: int) -> None:
        """Set the wheels' servos for a part of the tick."""
        arc = self._arcs[part]
        across = 0.5 * arc.aside * self._body.track / self._body.offset
        self._control[self._servos[0]] = (arc.ahead - across) / self._radius
        self._control[self._servos[1]] = (arc.ahead + across) / self._radius

    def read_encoders(self) -> None:
        """Odometry: as far as the wheels have turned, they have rolled."""
        left, right = (float(wheel.qpos[0]) for wheel in self._wheels)
        rolled_left, rolled_right = (
            self._radius * (left - self._angles[0]),
            self._radius * (right - self._angles[1]),
        )
        self._angles = [left, right]
        turn = (rolled_right - rolled_left) / self._body.track
        arc = Arc(0.5 * (rolled_left + rolled_right), turn * self._body.offset, 1.0)
        cx, cy = chord(arc, turn)
        dx, dy = turned(cx, cy, self._turned)
        self._turned += turn
        self._odometry = (self._odometry[0] + dx, self._odometry[1] + dy)

    def report(self) -> Report:
        """What the base says of itself."""
        arc = self._base.halt(self.motion)
        cx, cy = chord(arc, self._base.turn(arc))
        stop = turned(cx, cy, self.motion.heading)
        return Report(self._moved, self.motion.velocity, self.motion.heading, stop)


def _substeps(period: float) -> int:
    """Time steps of the engine in a part of a tick."""
    count = round(period / (STEPS * TIMESTEP))
    if count < 1 or abs(count * STEPS * TIMESTEP - period) > 1e-9:
        raise UsageError(
            f'world.plant = "mujoco" needs a time.step in steps of {STEPS * TIMESTEP:g} s, not {period:g} s'
        )
    return count
