"""The paper's law: u_i = -s D_i, integrated within the period; away from a deadlock if need be and wanted."""

from __future__ import annotations

import math
from collections.abc import Sequence

from agents.navigation import pace
from agents.navigation.deadlock import Progress, barred, circling
from agents.navigation.flow import Flow, desired_velocity
from agents.navigation.slice import Gradient, Peer, Slice
from agents.peers.neighbours import Neighbours
from agents.peers.state import PeerState
from protocol.scenario.model import Scenario

Vector = tuple[float, float]


class GradientLaw:
    """One robot's slice of the gradient of the navigation function."""

    def __init__(self, scenario: Scenario, robot: int) -> None:
        spec, control = scenario.spec(robot), scenario.control
        self._goal, self._radius = spec.goal, spec.radius
        self._workspace, self._k = scenario.workspace.radius, scenario.k
        self._speed, self._period = control.speed, scenario.time.step
        self._common = control.pace == "common"
        self._tolerance = scenario.time.tolerance
        self._max_rate = pace.max_rate(control.speed, scenario.time.step, scenario.time.tolerance)
        lap = max(each.radius for each in scenario.robots) / control.speed
        self._progress = Progress(scenario.time.step, lap) if control.escape else None
        self._wanted: Vector = (0.0, 0.0)
        self._slice: Slice | None = None

    def velocity(self, position: Vector, displacement: Vector, neighbours: Neighbours, tick: int) -> Vector:
        """See `agents.laws.law.Law`."""
        peers = neighbours.disks()
        field = self._slice = Slice(self._goal, self._radius, self._workspace, self._k, peers)
        begin = field.gradient(*position)
        moving = neighbours.moving()
        scale = self._scale(math.hypot(begin.dx, begin.dy), position, moving)
        free = self._free(position, scale)
        strength = self._stuck(position, displacement, free, peers, moving, tick)
        self._wanted = self._follow(Flow(field, scale), position, begin)
        if strength == 0.0:
            return self._wanted
        vx, vy = circling(position, self._goal, self._radius, peers)
        drift = (strength * free * vx, strength * free * vy)
        return self._follow(Flow(field, scale, drift), position, begin)

    def slice_norm(self, position: Vector) -> float:
        """See `agents.laws.law.Law`; before the first tick the attraction alone."""
        return 2.0 * self._away(position) if self._slice is None else self._slice.norm(*position)

    def _follow(self, flow: Flow, position: Vector, begin: Gradient) -> Vector:
        return desired_velocity(flow, position, period=self._period, speed=self._speed, begin=begin)

    def _scale(self, slice_norm: float, position: Vector, moving: Sequence[PeerState]) -> float:
        if not self._common:
            return pace.own_pace(self._max_rate)
        gamma = self._away(position) ** 2
        for state in moving:
            slice_norm, gamma = max(slice_norm, state.slice), max(gamma, state.gamma)
        return pace.common_pace(slice_norm, gamma, self._speed, self._max_rate)

    def _stuck(
        self,
        position: Vector,
        displacement: Vector,
        free: float,
        peers: list[Peer],
        moving: Sequence[PeerState],
        tick: int,
    ) -> float:
        """How strongly to escape from a deadlock, 0 to 1."""
        if self._progress is None:
            return 0.0
        gamma, oldest = 0.0, tick
        for peer in peers:
            gamma += peer.gamma
        for state in moving:
            oldest = min(oldest, state.tick)
        return self._progress.update(
            displacement=displacement,
            desired=self._wanted,
            free=free,
            gamma=self._away(position) ** 2 + gamma,
            barred=lambda: barred(position, self._goal, self._radius, peers),
            latency=(tick - oldest) * self._period,
        )

    def _free(self, position: Vector, scale: float) -> float:
        """Speed that attraction alone would give, m/s; 0 at the goal."""
        away = self._away(position)
        return min(self._speed, 2.0 * scale * away) if away > self._tolerance else 0.0

    def _away(self, position: Vector) -> float:
        """Distance to the own goal, m."""
        return math.hypot(position[0] - self._goal[0], position[1] - self._goal[1])
