"""What the cores cost without any network, against a floor in plain numpy.

Slice, safety filter (ledger and safe velocity), codec, one tick of a robot, one tick of the world; in
microseconds. The floor of a core is what numpy takes to do its arithmetic alone, with nothing decided,
checked or wrapped: pair differences and their squared lengths for what looks at every pair, two copies
of the bytes for the codec.

    python -m tests.benchmarks.machine.cores --robots 6 32
"""

from __future__ import annotations

import argparse
import timeit
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from agents.law.gradient import Slice
from agents.lines.boundary import RoundBoundary
from agents.lines.safe_velocity import safe_velocity
from agents.lines.separating_lines import SeparatingLines
from agents.peers.state import Peer, addressed_to
from agents.robot import Robot
from deploy.library.load import load
from protocol.codec import decode, encode
from protocol.keys import robot_key
from protocol.messages import Command, Sense, State, Tick
from protocol.scenario.model import Scenario
from world.world import World

ROBOTS = (6, 32, 64, 200)


class Cost(NamedTuple):
    """Microseconds of one call, and of the same arithmetic in plain numpy."""

    core: float
    floor: float


class Fleet:
    """All robots of a random instance and their world, ticked by hand, without codec or bus."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario, self.world = scenario, World(scenario)
        lives = {robot: self.world.coordinator.join(robot) for robot in scenario.ids}
        self.robots = {i: Robot(scenario, i, life) for i, life in lives.items()}
        self.states: dict[int, State] = {}
        self.radii = {spec.id: spec.radius for spec in scenario.robots}

    def tick(self) -> None:
        """One tick of everybody."""
        told = self.world.open_tick()
        self.states = {i: robot.begin(told[i]) for i, robot in self.robots.items()}
        for i, robot in self.robots.items():
            self._tell(i, robot)
        for robot in self.robots.values():
            self.world.accept(robot.command())
        self.world.close_tick()

    def _tell(self, own: int, robot: Robot) -> None:
        for peer, state in self.states.items():
            if peer != own:
                robot.hearing.on_state(addressed_to(own, state, self.radii[peer]))

    def robot_tick(self) -> Callable[[], Command]:
        """A function that is robot 1's next tick, with all others' States as they are."""
        robot, tick = self.robots[1], self.robots[1].tick
        mine, peers = self.states[1], [state for i, state in self.states.items() if i != 1]
        active = self.scenario.ids
        ahead = [tick]

        def step() -> Command:
            ahead[0] += 1
            sense = Sense(mine.position, ahead[0], 0.0, (0.0, 0.0))
            robot.begin(Tick(1, mine.incarnation, ahead[0], active, sense=sense))
            for state in peers:
                robot.hearing.on_state(addressed_to(1, _at(state, ahead[0]), self.radii[state.robot]))
            return robot.command()

        return step

    def world_tick(self) -> Callable[[], object]:
        """A function that is the world's next tick, in which everybody stands still."""
        world, lives = self.world, self.world.coordinator.lives.incarnations

        def step() -> object:
            world.open_tick()
            for robot, life in lives.items():
                world.accept(Command(robot, life, world.tick, (0.0, 0.0)))
            return world.close_tick()

        return step


def _at(state: State, tick: int) -> State:
    return State(
        state.robot,
        state.incarnation,
        tick,
        state.position,
        state.bound,
        state.gamma,
        state.slice,
        state.desired,
    )


def calls(robots: int) -> dict[str, tuple[Callable[[], object], Callable[[], object]]]:
    """Each core with that many robots, after ten ticks of a random instance, and its floor."""
    fleet = Fleet(load(f"random-{robots}"))
    for _ in range(10):
        fleet.tick()
    one, pairs = _floor(robots, 1), _floor(robots, robots)
    return {
        "slice": (_slice(fleet), one),
        "filter": (_filter(fleet), one),
        "codec": _codec(fleet),
        "robot": (fleet.robot_tick(), one),
        "world": (fleet.world_tick(), pairs),
    }


def costs(robots: int, repeat: int = 9, number: int = 64) -> dict[str, Cost]:
    """What each core costs; `number` calls count together, among them those in which the world judges."""

    def measured(call: Callable[[], object]) -> float:
        return 1e6 * min(timeit.repeat(call, number=number, repeat=repeat)) / number

    return {name: Cost(measured(core), measured(floor)) for name, (core, floor) in calls(robots).items()}


def _floor(robots: int, rows: int) -> Callable[[], object]:
    """Squared distances of `rows` robots to all."""
    places = np.random.default_rng(0).random((robots, 2))
    some = places[:rows, None]

    def distances() -> object:
        apart = some - places
        return np.einsum("ijk,ijk->ij", apart, apart)

    return distances


def _slice(fleet: Fleet) -> Callable[[], object]:
    """Build the slice of robot 1 and take its gradient."""
    scenario, states = fleet.scenario, fleet.states
    spec, own = scenario.spec(1), states[1].position
    assert own is not None
    radii = {robot.id: robot.radius for robot in scenario.robots}
    peers = [
        Peer(*state.position, radii[i], state.gamma)
        for i, state in states.items()
        if i != 1 and state.position is not None
    ]
    edge, k = scenario.workspace.radius, scenario.k
    return lambda: Slice(spec.goal, spec.radius, edge, k, peers).gradient(*own)


def _filter(fleet: Fleet) -> Callable[[], object]:
    """One tick of robot 1's ledger, and the velocity nearest to the desired one."""
    scenario, states = fleet.scenario, fleet.states
    radii = {robot.id: robot.radius for robot in scenario.robots}
    starts = {i: state.position for i, state in states.items() if state.position is not None}
    speed, period = scenario.control.speed, scenario.time.step
    boundary = RoundBoundary(scenario.workspace.radius - radii[1])
    ledger = SeparatingLines(1, 1, radii, speed=speed, period=period, starts=starts)
    own, desired = starts[1], states[1].desired
    tick = [0]

    def step() -> object:
        tick[0] += 1
        ledger.locate(tick[0], own, 0.0)
        spoken = ledger.entries(desired)
        for i, state in states.items():
            if i != 1:
                ledger.on_state(addressed_to(1, _at(state, tick[0]), radii[state.robot]))
        planes = ledger.half_planes() if ledger.ready else []
        return spoken, safe_velocity(desired, own, planes, boundary=boundary, speed=speed, period=period)

    return step


def _codec(fleet: Fleet) -> tuple[Callable[[], object], Callable[[], object]]:
    """Encode the own State, decode everybody's."""
    payloads = [(robot_key("bench", i, "state"), encode(state)) for i, state in fleet.states.items()]
    own = fleet.states[1]

    def core() -> object:
        encode(own)
        return [decode(key, payload) for key, payload in payloads]

    return core, lambda: [bytes(bytearray(payload)) for _, payload in payloads]


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--robots", type=int, nargs="+", default=ROBOTS)
    options = parser.parse_args()
    print(f"{'robots':>6} {'core':<8} {'us':>9} {'us/robot':>9} {'floor us':>9} {'ratio':>7}")
    for robots in options.robots:
        for name, cost in costs(robots).items():
            print(
                f"{robots:6d} {name:<8} {cost.core:9.1f} {cost.core / robots:9.2f}"
                f" {cost.floor:9.1f} {cost.core / cost.floor:7.1f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
