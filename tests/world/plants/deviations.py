"""By how much bodies in MuJoCo are off the ways that `protocol.bodies` gives them, and their odometry off.

Each robot is alone, and driven by random commands: at full speed and slowly, straight, on the spot, to and
fro, with some commands lost. From every tick on in which it moves, the nominal way is drawn from where it
is, and compared with the true one until the next command. Measured is what is lacking of a body's `play`,
if its `error` and `lag` are as stated, and of its `drift`, if its `odometry` is; negative if nothing is.
"""

import math
from random import Random
from types import SimpleNamespace
from typing import NamedTuple

from protocol.bodies.kinematics import Kinematics, turned
from protocol.bodies.sweep import Tolerance
from protocol.messages import STILL, Vector
from protocol.scenario.body import PRESETS, Body
from protocol.scenario.model import RobotSpec, Scenario, Time, Workspace
from protocol.scenario.model import World as WorldTable
from world.plants.integrator import SimulatedBase
from world.plants.mujoco import Physics

ROBOTS = 9
APART = 100.0  # m
PERIODS = (0.01, 0.02, 0.033, 0.05, 0.1, 0.2, 0.5, 1.0)  # s
WHEELED = tuple(name for name in PRESETS if name != "point")


class Lacking(NamedTuple):
    """What would have to be added to what a body states, m."""

    play: float
    drift: float


_EXACT = SimpleNamespace(at=lambda _: STILL)  # errors of a base whose way is the nominal one


class _Way:
    """A nominal way from where a robot is, m, and how far the robot may be off it."""

    def __init__(self, base: SimulatedBase, place: Vector, slip: float) -> None:
        self.base, self.place, self.slip, self.length = base, place, slip, 0.0


def lacking(body: Body, period: float, ticks: int, seed: int = 0) -> Lacking:
    """Drive a fleet of a body at random.

    Args:
        body: of all robots.
        period: of a tick, s.
        ticks: that are driven, by each of the robots.
        seed: of the commands.
    """
    side = math.isqrt(ROBOTS)
    places = [(APART * (n % side), APART * (n // side)) for n in range(ROBOTS)]
    specs = tuple(RobotSpec(n + 1, body.disk or 0.0, place, place) for n, place in enumerate(places))
    scenario = Scenario(
        specs, workspace=Workspace(1e3), time=Time(step=period), body=body, world=WorldTable("mujoco")
    )
    plant, rng = Physics(scenario), Random(seed)
    drivers = [_Driver(body, period, rng) for _ in specs]
    play = drift = -math.inf
    for tick in range(ticks):
        commands = {}
        for index, driver in enumerate(drivers):
            motion = plant.report(index)
            command = driver.command(motion.velocity, motion.heading)
            if command is not None:
                commands[index + 1] = command
        before = plant.positions
        for index, driver in enumerate(drivers):
            driver.begin(plant, index, commands.get(index + 1))
        plant.move(commands, tick)
        for index, driver in enumerate(drivers):
            passed = [each[index] for each in (*plant.between, plant.positions)]
            play = max(play, driver.beyond(commands.get(index + 1), passed, tick))
            said = plant.report(index)
            (x, y), (x0, y0) = plant.positions[index], before[index]
            off = math.hypot(x - x0 - said.displacement[0], y - y0 - said.displacement[1])
            drift = max(drift, off - body.odometry * said.way - body.drift)
    return Lacking(play, drift)


class _Driver:
    """What one robot is told, and the nominal ways of the ticks since its last command."""

    def __init__(self, body: Body, period: float, rng: Random) -> None:
        self._kinematics, self._tolerance = Kinematics(body, period), Tolerance(body)
        self._rng, self._most = rng, 1.2 * self._kinematics.top_speed
        self._often = min(0.9, 1.5 * period + 0.1)  # how often it is told something else
        self._kind, self._wants = "there", STILL
        self._ways: list[_Way] = []

    def command(self, velocity: Vector, heading: float) -> Vector | None:
        rng = self._rng
        if rng.random() < self._often:
            angle, speed = rng.uniform(0.0, math.tau), rng.choice((1.0, 1.0, 1.0, 0.3, 0.1)) * self._most
            self._kind = rng.choice(("there", "there", "spin", "straight", "reverse"))
            self._wants = speed * math.cos(angle), speed * math.sin(angle)
        luck = rng.random()
        if luck < 0.08:
            return None
        if luck < 0.12:
            return STILL
        if self._kind == "spin":
            return turned(0.0, rng.choice((1.0, 1.0, 1.0, -1.0)) * self._most, heading)
        if self._kind == "straight":
            return turned(rng.choice((1.0, 1.0, 1.0, -1.0)) * self._most, 0.0, heading)
        return (-3.0 * velocity[0], -3.0 * velocity[1]) if self._kind == "reverse" else self._wants

    def begin(self, plant: Physics, index: int, command: Vector | None) -> None:
        """A tick begins, and with it another nominal way."""
        said, kinematics = plant.report(index), self._kinematics
        motion = kinematics.motion(said.velocity, said.heading, said.stop or STILL)
        to = (motion.ahead, motion.aside)
        if command is not None and command != STILL:
            self._ways.clear()
            to = kinematics.limited(motion, command)
        elif motion.stands:
            return
        base = SimulatedBase(kinematics, self._tolerance, motion, _EXACT)
        self._ways.append(_Way(base, plant.positions[index], self._tolerance.slip(motion, to)))

    def beyond(self, command: Vector | None, passed: list[Vector], tick: int) -> float:
        """Go through a tick; the most by which a place was beyond what is allowed around a nominal way, m."""
        most = -math.inf
        for way in self._ways:
            for (dx, dy), (px, py) in zip(way.base.move(command, tick), passed, strict=True):
                x, y = way.place = way.place[0] + dx, way.place[1] + dy
                way.length += math.hypot(dx, dy)
                allowed = self._tolerance.error * way.length + way.slip
                most = max(most, math.hypot(px - x, py - y) - allowed)
        return most
