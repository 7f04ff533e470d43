"""What robots of skirmishes wish: to collide, or to stay."""

import math
from random import Random
from typing import Any

from protocol.messages import Vector
from tests.agents.lines.models.skirmishes.arena import SPEED


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
