"""Short ways to set up and drive a world without robots, and time that goes on when it is told to."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from protocol.bus.local import LocalNetwork
from protocol.keys import parse
from protocol.messages import Command, FirstLine, Tick, Vector
from protocol.scenario.model import Control, RobotSpec, Scenario, Time
from world.world import WorldCore

STEP = 0.05


def scenario(*robots: tuple[Vector, Vector], radius: float = 0.04, **settings: object) -> Scenario:
    """Robots 1, 2, ... given as (start, goal); short times unless given."""
    specs = tuple(RobotSpec(n, radius, start, goal) for n, (start, goal) in enumerate(robots, 1))
    defaults = Scenario(
        specs,
        control=Control(k=60.0),
        time=Time(step=STEP, limit=10.0, tolerance=0.005, fence=0.2, deadlock=0.5),
    )
    return replace(defaults, **settings)


def two(**settings: object) -> Scenario:
    return scenario(((-0.1, 0.1), (0.1, 0.1)), ((-0.1, -0.1), (0.1, -0.1)), **settings)


def joined(setting: Scenario, robots: Iterable[int] | None = None) -> WorldCore:
    world = WorldCore(setting)
    for robot in setting.ids if robots is None else robots:
        world.join(robot)
    return world


def advance(world: WorldCore, velocities: Mapping[int, Vector] | None = None) -> None:
    """One tick in which every active robot commands, zero unless told otherwise."""
    told = world.open_tick()
    assert not world.lives.awaited
    for robot in world.exchange.active:
        assert world.accept(obeying(told[robot], (velocities or {}).get(robot, (0.0, 0.0))))
    assert not world.exchange.waiting
    world.close_tick()


def obeying(told: Tick, velocity: Vector = (0.0, 0.0), *, clear: bool = True, **said: Any) -> Command:
    """A Command of a robot that obeys all that it was told, also first lines for which it is asked; unless it
    is not `clear` of what they are for, and says nothing of it."""
    roster, grants = told.roster, told.grants
    if grants is not None and clear:
        asked = [each.number for each in grants.bindings if each.first is None]
        firsts = tuple(FirstLine(number, 1.0, 0.0, 0.0) for number in asked)
        region = grants.number if grants.number > grants.life else 0
        said = {"version": grants.version, "region": region, "firsts": firsts, **said}
    version = 0 if roster is None else roster.version
    return Command(told.robot, told.incarnation, told.tick, velocity, roster=version, **said)


def toward(world: WorldCore, setting: Scenario) -> dict[int, Vector]:
    """Velocities straight to the goals, at the speed limit or less."""
    velocities = {}
    for robot, (x, y) in zip(world.truth.robots, world.truth.positions, strict=True):
        gx, gy = setting.spec(robot).goal
        velocities[robot] = ((gx - x) / STEP, (gy - y) / STEP)
    return velocities


def play(setting: Scenario) -> WorldCore:
    """All robots go straight to their goals until a verdict."""
    world = joined(setting)
    while not world.verdict:
        assert world.tick < 1000
        advance(world, toward(world, setting))
    return world


def token(network: LocalNetwork, robot: int | None = None) -> str:
    """Key of the liveliness token of a robot's newest process, or of the world."""
    return [key for key in network.tokens() if parse(key).robot == robot][-1]


@dataclass
class Stopwatch:
    now: float = 0.0

    def __call__(self) -> float:
        return self.now
