"""Where skirmishes take place: little room, obstacles in it, and few robots, all of it drawn from a seed; and
what these wish: to collide, or to stay."""

import math
from random import Random
from typing import Any, Literal

from protocol.messages import Vector
from protocol.scenario.body import Actuation, Body
from protocol.scenario.model import Control, Obstacle, RobotSpec, Scenario, Sensing, Time, Workspace
from protocol.scenario.network import Network

STEP, SPEED = 0.05, 0.6  # s, m/s: a tick leads nearly as far as a small disk reaches


def drawn(seed: int, rng: Random) -> Scenario:
    """Three or four robots in little room."""
    room = 0.22
    specs: list[RobotSpec] = []
    while len(specs) < 3 + (seed % 3 == 0):
        radius = rng.uniform(0.02, 0.06)
        start = (rng.uniform(-room, room), rng.uniform(-room, room))
        apart = all(math.dist(start, each.start) > radius + each.radius + 1e-3 for each in specs)
        if apart and math.hypot(*start) + radius < room - 1e-3:
            specs.append(RobotSpec(len(specs) + 1, radius, start, (0.0, 0.0)))
    noise = rng.choice((0.0, 0.002, 0.01))
    sensing = Sensing(
        delay=rng.choice((0.0, 0.0, 0.1, (0.0, 0.3))),
        noise=noise,
        noise_bound=noise * rng.choice((1.0, 2.0)),
        bias=(noise * rng.uniform(-1.0, 1.0), noise * rng.uniform(-1.0, 1.0)),
        dropout=rng.choice((0.0, 0.0, 0.3)),
    )
    return Scenario(
        tuple(specs),
        seed=seed,
        workspace=_room(seed, room),
        time=Time(step=STEP, limit=1e3, tolerance=1e-6, fence=STEP * rng.choice((1, 3, 8)), deadlock=1e3),
        control=Control(k=20.0, speed=SPEED),
        sensing=(sensing,),
        actuation=Actuation(rng.choice((0.0, 0.0, 0.1))),
        obstacles=_obstacles(seed, specs, room),
        body=_body(seed),
        network=_network(seed),
    )


def obstacle_beside(rng: Random, place: Vector) -> Obstacle:
    """A disk or a thin wall some way off a robot, where it may soon be."""
    turn, far, size = rng.uniform(0.0, math.tau), rng.uniform(0.0, 0.12), rng.uniform(0.003, 0.02)
    cos, sin = math.cos(turn), math.sin(turn)
    x, y = place[0] + far * cos, place[1] + far * sin
    if rng.random() < 0.5:
        return Obstacle(center=(x, y), radius=size)
    corners = ((0.002, size), (-0.002, size), (-0.002, -size), (0.002, -size))
    return Obstacle(points=tuple((x + cos * u - sin * v, y + sin * u + cos * v) for u, v in corners))


def _network(seed: int) -> Network:
    """Every robot receives all States in three of five runs, those of near peers only in the others."""
    if seed % 5 not in (1, 4):
        return Network("all")
    return Network("near", Random(f"network {seed}").choice((1e-3, 0.02, 0.1)))


def _body(seed: int) -> Body | Literal["point"]:
    """A point; in one of four runs a base that holds its velocity and brakes, on wheels or without."""
    if seed % 4 != 2:
        return "point"
    rng = Random(f"body {seed}")
    error, lag, play = rng.choice(((0.0, 0.0, 0.0), (0.05, 0.01, 1e-3)))
    odometry, drift = rng.choice(((0.0, 0.0), (0.1, 1e-3)))
    acceleration, hold = rng.choice((3.0, 10.0, 50.0)), rng.choice((0.0, 0.02, 0.1))
    slips = {"error": error, "lag": lag, "play": play, "odometry": odometry, "drift": drift}
    if rng.random() < 0.5:
        return Body("omnidirectional", acceleration=acceleration, hold=hold, **slips)
    return Body("differential-drive", None, 0.02, 0.04, 1.5, acceleration, hold, **slips)


def _room(seed: int, room: float) -> Workspace:
    """A disk; in one of eight runs a polygon around it."""
    if seed % 8 != 7:
        return Workspace(room)
    rng = Random(f"room {seed}")
    sides, turn = rng.randint(3, 6), rng.random()
    reach = room / math.cos(math.pi / sides)
    angles = [turn + math.tau * side / sides for side in range(sides)]
    return Workspace(points=tuple((reach * math.cos(each), reach * math.sin(each)) for each in angles))


def _obstacles(seed: int, specs: list[RobotSpec], room: float) -> tuple[Obstacle, ...]:
    """None; in one of four runs up to three, close to where the robots begin."""
    if seed % 4 != 3:
        return ()
    rng = Random(f"obstacles {seed}")
    drawn = [_obstacle(rng, room) for _ in range(40)]
    clear = [
        each for each in drawn if all(each.shape.distance(*spec.start) > spec.radius + 1e-3 for spec in specs)
    ]
    return tuple(clear[: rng.randint(1, 3)])


def _obstacle(rng: Random, room: float) -> Obstacle:
    x, y = rng.uniform(-room, room), rng.uniform(-room, room)
    if rng.random() < 0.4:
        return Obstacle(center=(x, y), radius=rng.uniform(0.005, 0.06))
    ahead, aside = rng.uniform(0.005, 0.1), rng.uniform(0.001, 0.05)
    turn = rng.uniform(0.0, math.tau)
    cos, sin = math.cos(turn), math.sin(turn)
    corners = ((ahead, aside), (-ahead, aside), (-ahead, -aside), (ahead, -aside))[: rng.choice((3, 4))]
    return Obstacle(points=tuple((x + cos * u - sin * v, y + sin * u + cos * v) for u, v in corners))


class Attack:
    """Wants to collide: for some ticks at a peer, past it, or at the wall."""

    failure = ""

    def __init__(self, rng: Random, world: Any, robot: int) -> None:
        self._rng, self._world, self._robot = rng, world, robot
        self._obstacles = [(shape.around.x, shape.around.y) for shape in world.scenario.shapes.values()]
        self._targets = len(world.truth.robots) + len(self._obstacles)
        self._target, self._turn = 0, 0.0

    def slice_norm(self, *_: Any) -> float:
        return 0.0

    def velocity(self, view: Any) -> Vector:
        position, rng, truth = view.position, self._rng, self._world.truth
        if rng.random() < 0.15:
            self._target, self._turn = rng.randint(-1, self._targets - 1), rng.uniform(-0.6, 0.6)
        places = (*truth.positions, *self._obstacles)
        x, y = places[self._target] if self._target >= 0 else (2.0 * position[0], 2.0 * position[1])
        angle = math.atan2(y - position[1], x - position[0]) + self._turn
        speed = SPEED * rng.choice((0.3, 1.0, 1.0))
        return speed * math.cos(angle), speed * math.sin(angle)


class Staying:
    failure = ""

    def slice_norm(self, *_: Any) -> float:
        return 0.0

    def velocity(self, _: Any) -> Vector:
        return 0.0, 0.0
