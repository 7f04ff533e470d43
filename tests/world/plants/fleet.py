"""A whole fleet in one loop, without a bus: the real world and real robots, whose commands get lost."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from random import Random
from typing import Any, Literal

from agents.bodies.point import PointBody
from agents.peers.state import addressed_to
from agents.robot import Robot
from protocol.scenario.model import Control, Link, RobotSpec, Scenario, Sensing, Time, Workspace
from protocol.scenario.model import World as WorldTable
from world.world import World

SPACING = 0.12  # m, between neighbours at the start
TOLERANCE = 0.02  # m


@dataclass(frozen=True)
class Setting:
    """What one run is about."""

    robots: int = 6
    plant: str = "mujoco"
    body: str = "turtlebot3-burger"
    radius: float = 0.15  # m
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
            workspace=Workspace(circle + 0.5),
            time=Time(limit=240.0, tolerance=TOLERANCE),
            control=Control(k=self.k, pace=self.pace, speed=self.speed),
            sensing=(Sensing(noise=self.noise, noise_bound=2.0 * self.noise, heading=self.heading),),
            link=Link(delay=self.delay, loss=self.loss),
            world=WorldTable(self.plant),
            body=self.body,
        )


def drive(setting: Setting, naive: bool = False) -> dict[str, Any]:
    """Go through a run; its report.

    Args:
        naive: whether the robots take their bodies for points.
    """
    scenario, lost = setting.scenario, Random(setting.seed)
    world = World(scenario)
    robots = {robot: Robot(scenario, robot, world.coordinator.join(robot)) for robot in scenario.ids}
    for robot in robots.values() if naive else ():
        robot._body = PointBody(scenario.control.speed, scenario.time.step, 0.0)
    while not world.verdict:
        states = {robot: robots[robot].begin(tick) for robot, tick in world.open_tick().items()}
        for robot, core in robots.items():
            others = [each for each in scenario.ids if each != robot]
            for peer in others:
                core.hearing.on_state(addressed_to(robot, states[peer], setting.radius))
        for core in robots.values():
            command = core.command()
            if lost.random() >= setting.dropped:
                world.accept(command)
        world.close_tick()
    return world.report()


def varied(seed: int) -> Setting:
    """One of many: delays, losses and noise by turns."""
    rng = Random(seed)
    return replace(
        Setting(seed=seed),
        robots=rng.choice((4, 6, 8)),
        delay=rng.choice((0.0, 0.3)),
        loss=rng.choice((0.0, 0.3)),
        dropped=rng.choice((0.0, 0.1)),
        noise=rng.choice((0.0, 0.003)),
        heading=rng.choice((0.0, 0.03)),
        speed=rng.choice((0.1, 0.2)),
        k=rng.choice((40.0, 80.0, 200.0)),
        pace=rng.choice(("common", "own")),
    )
