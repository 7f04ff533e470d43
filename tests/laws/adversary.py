"""A law that wants a touch: at full speed at the nearest disk, wall or obstacle, back, anywhere, or to where
clearance falls fastest, each for some ticks; the filter has to hold against it.

disknav run turtlebots-6 --set control.law=tests.laws.adversary:Adversary --set time.endless=true
"""

import math
from random import Random
from typing import Final

from agents.law import View
from protocol.messages import Vector
from protocol.scenario.model import Scenario

_KINDS: Final = ("greedy", "greedy", "chase", "anywhere", "back", "goal")
_SPEEDS: Final = (1.0, 1.0, 1.0, 1.0, 0.3, 0.03)  # of the speed limit
_DIRECTIONS: Final = 16  # that greed compares


class Adversary:
    """Drawn from the scenario's seed and the robot's id."""

    def __init__(self, scenario: Scenario, robot: int) -> None:
        self._rng = Random(f"{scenario.seed} {robot}")
        self._room, self._speed = scenario.workspace.shape, scenario.control.speed
        self._radius = scenario.spec(robot).radius
        self._ahead = 2.0 * self._speed * scenario.time.step + 0.02  # m that greed looks ahead
        self._kind, self._share, self._left, self._last = "greedy", 1.0, 0, (0.0, 0.0)

    def velocity(self, view: View) -> Vector:
        rng = self._rng
        if self._left == 0:
            self._kind, self._share = rng.choice(_KINDS), rng.choice(_SPEEDS)
            self._left = rng.choice((1, 2, 5, 20, 80))
            if self._kind == "anywhere":
                self._last = _towards(rng.uniform(-math.pi, math.pi))
            if self._kind == "back":
                self._last = (-self._last[0], -self._last[1])
        self._left -= 1
        if self._kind == "greedy":
            self._last = self._greed(view)
        elif self._kind == "chase":
            self._last = self._to_nearest(view)
        elif self._kind == "goal":
            self._last = _unit(view.goal[0] - view.position[0], view.goal[1] - view.position[1])
        speed = self._share * self._speed
        return speed * self._last[0], speed * self._last[1]

    def _to_nearest(self, view: View) -> Vector:
        x, y = view.position
        peers = view.neighbours.disks()
        if not peers:
            return self._greed(view)
        nearest = min(peers, key=lambda peer: math.hypot(peer.x - x, peer.y - y) - peer.radius)
        return _unit(nearest.x - x, nearest.y - y)

    def _greed(self, view: View) -> Vector:
        first = self._rng.uniform(-math.pi, math.pi)
        directions = [_towards(first + math.tau * n / _DIRECTIONS) for n in range(_DIRECTIONS)]
        return min(directions, key=lambda towards: self._clearance(view, towards))

    def _clearance(self, view: View, towards: Vector) -> float:
        """Smallest gap between the own disk a little ahead and anything, m."""
        x, y = view.position[0] + self._ahead * towards[0], view.position[1] + self._ahead * towards[1]
        gap = -self._room.distance(x, y)
        for peer in view.neighbours.disks():
            gap = min(gap, math.hypot(peer.x - x, peer.y - y) - peer.radius)
        for obstacle in view.obstacles:
            gap = min(gap, obstacle.distance(x, y))
        return gap - self._radius


def _towards(angle: float) -> Vector:
    return math.cos(angle), math.sin(angle)


def _unit(x: float, y: float) -> Vector:
    length = math.hypot(x, y)
    return (x / length, y / length) if length > 0.0 else (1.0, 0.0)
