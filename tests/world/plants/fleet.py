"""A whole fleet in one loop, without a bus: the real world and real robots, whose commands get lost, and in
formulas, whose bases are off towards whatever is nearest by as much as they may be."""

import math
from dataclasses import dataclass, replace
from random import Random
from typing import Any, Literal

from agents.bodies import PointBody
from agents.peers.state import addressed_to
from agents.robot import Robot
from protocol.messages import Vector
from protocol.scenario.body import PRESETS, Body, Preset
from protocol.scenario.model import Control, RobotSpec, Scenario, Sensing, Time, Workspace
from protocol.scenario.model import World as WorldTable
from protocol.scenario.network import Link
from world.plants.integrator import Integrator
from world.report import result_of
from world.world import WorldCore

ADVERSARY = "tests.laws.adversary:Adversary"
SPACING = 0.12  # m, between neighbours at the start
TOLERANCE = 0.02  # m


@dataclass(frozen=True)
class Setting:
    robots: int = 6
    plant: str = "mujoco"
    body: Preset | Body = "turtlebot3-burger"
    radius: float = 0.15  # m
    period: float = 0.05  # s
    law: str = "gradient"
    ticks: int = 0  # how long it lasts; 0: until all have arrived
    delay: float = 0.0  # s, of States
    loss: float = 0.0  # of States
    dropped: float = 0.0  # of commands
    noise: float = 0.0  # m, of measured positions; twice that at most
    heading: float = 0.0  # rad, error of directions
    speed: float = 0.1  # m/s
    k: float = 40.0
    pace: Literal["common", "own"] = "common"
    seed: int = 0

    @property
    def scenario(self) -> Scenario:
        """Robots on a circle, about evenly, each to the opposite place, facing anywhere."""
        rng = Random(self.seed)
        circle = max(0.6, (2.0 * self.radius + SPACING) * self.robots / math.tau)
        specs = []
        for number in range(self.robots):
            angle = math.tau * (number + rng.uniform(-0.1, 0.1)) / self.robots
            x, y = circle * math.cos(angle), circle * math.sin(angle)
            specs.append(RobotSpec(number + 1, self.radius, (x, y), (-x, -y), rng.uniform(-math.pi, math.pi)))
        return Scenario(
            tuple(specs),
            name=f"swap-{self.robots}",
            seed=self.seed,
            workspace=Workspace(circle + self.radius + (0.1 if self.ticks else 0.35)),
            time=Time(
                step=self.period,
                limit=240.0,
                tolerance=TOLERANCE,
                endless=self.ticks > 0,
                deadlock=1e6 if self.ticks else 20.0,
            ),
            control=Control(k=self.k, speed=self.speed, law=self.law).without(
                *(["pace"] if self.pace == "own" else [])
            ),
            sensing=(Sensing(noise=self.noise, noise_bound=2.0 * self.noise, heading=self.heading),),
            link=Link(delay=self.delay, loss=self.loss),
            world=WorldTable(self.plant),
            body=self.body,
        )


def drive(setting: Setting, naive: bool = False, stated: Body | None = None) -> dict[str, Any]:
    """Go through a run; its report.

    Args:
        naive: whether the robots take their bodies for points.
        stated: what the robots take their bodies for, if that is not what they are.
    """
    scenario, lost = setting.scenario, Random(setting.seed)
    world = WorldCore(scenario)
    plant = world.simulation.plant
    if isinstance(plant, Integrator):
        for robot, base in plant._bases.items():
            base._errors = TowardsTheNearest(plant, plant.ids.index(robot), scenario)
    believed = scenario if stated is None else replace(scenario, body=stated)
    robots = {robot: Robot(believed, robot, world.join(robot)) for robot in scenario.ids}
    for robot in robots.values() if naive else ():
        robot._body = PointBody(scenario.control.speed, scenario.time.step, 0.0, math.inf)
    while not world.verdict and (not setting.ticks or world.tick < setting.ticks):
        states = {robot: robots[robot].begin(tick) for robot, tick in world.open_tick().items()}
        for robot, core in robots.items():
            others = [each for each in scenario.ids if each != robot]
            for peer in others:
                core.inbox.on_state(addressed_to(robot, states[peer], setting.radius))
        for core in robots.values():
            command = core.command()
            if lost.random() >= setting.dropped:
                world.accept(command)
        world.close_tick()
    return result_of(world)


class TowardsTheNearest:
    """The errors of one base: as large as they may be, towards a disk or the wall; sometimes none, or any."""

    def __init__(self, plant: Integrator, index: int, scenario: Scenario) -> None:
        self._plant, self._index = plant, index
        self._rng, self._rim = Random(index), scenario.workspace.shape.around.radius

    def at(self, tick: int) -> Vector:
        luck, turn = self._rng.random(), self._rng.uniform(-math.pi, math.pi)
        if luck < 0.1:
            return 0.0, 0.0
        x, y = self._plant.positions[self._index]
        dx, dy, gap = x, y, self._rim - math.hypot(x, y)
        for index, (px, py) in enumerate(self._plant.positions):
            if index != self._index and 0.5 * math.hypot(px - x, py - y) < gap:
                dx, dy, gap = px - x, py - y, 0.5 * math.hypot(px - x, py - y)
        if luck > 0.8 or dx == dy == 0.0:
            dx, dy = math.cos(turn), math.sin(turn)
        size = (1.0 - 1e-9) / math.hypot(dx, dy)
        return size * dx, size * dy


PERIODS = (0.01, 0.05, 0.1, 0.2, 0.5, 1.0)  # s
BODIES: dict[str, Preset | Body] = {
    "omnidirectional": Body("omnidirectional", acceleration=2.0, hold=0.2, error=0.2, lag=0.05, play=1e-3),
    "turtlebot3-burger": "turtlebot3-burger",
    "turtlebot3-waffle": "turtlebot3-waffle",
    "turtlebot4": "turtlebot4",
    "robotarium": "robotarium",
    "e-puck": "e-puck",
}


def hostile(name: str, period: float, plant: str, seed: int, ticks: int = 250) -> Setting:
    """Robots whose law wants a touch, in a narrow room."""
    rng, body = Random(f"{name} {period} {seed}"), BODIES[name]
    disk = PRESETS[body].disk if isinstance(body, str) else 0.1
    robots = rng.choice((2, 3, 4))
    return Setting(
        robots=robots,
        plant=plant,
        body=body,
        radius=disk or 0.1,
        period=period,
        law=ADVERSARY,
        ticks=ticks,
        delay=rng.choice((0.0, 0.0, 2.0 * period)),
        loss=rng.choice((0.0, 0.3)),
        dropped=rng.choice((0.0, 0.0, 0.2)),
        noise=rng.choice((0.0, 0.0, 0.003)),
        heading=rng.choice((0.0, 0.0, 0.03)),
        speed=rng.choice((0.1, 0.3, 1.0)),
        seed=seed,
    )
