"""The paper's law: u_i = -s D_i, integrated within the period; away from a deadlock if need be and wanted."""

from __future__ import annotations

import math
from collections.abc import Sequence

from agents.laws.view import View
from agents.navigation import pace
from agents.navigation.attraction import Attraction
from agents.navigation.deadlock import Progress, barred, circling
from agents.navigation.flow import Flow, desired_velocity
from agents.navigation.obstacles import round_boundary, standing
from agents.navigation.slice import Gradient, Peer, Slice
from agents.peers.state import PeerState
from protocol.scenario.gain import grown
from protocol.scenario.model import Scenario

Vector = tuple[float, float]


class GradientLaw:
    """One robot's slice of the gradient of the navigation function."""

    def __init__(self, scenario: Scenario, robot: int) -> None:
        spec, control = scenario.spec(robot), scenario.control
        self._radius = spec.radius
        self._room, self._k, self._robots = scenario.workspace.shape, scenario.k, len(scenario.robots)
        self._workspace = round_boundary(self._room)
        self._attraction = Attraction(self._room, spec.radius, alone=len(scenario.robots) == 1)
        self._aim = (spec.goal, spec.goal)  # the goal of the last tick, and where it pulled
        self._speed, self._period = control.speed, scenario.time.step
        self._common = control.pace == "common"
        self._tolerance = scenario.time.tolerance
        self._max_rate = pace.max_rate(control.speed, scenario.time.step, scenario.time.tolerance)
        lap = max(each.radius for each in scenario.robots) / control.speed
        self._progress = Progress(scenario.time.step, lap) if control.escape else None
        self._wanted: Vector = (0.0, 0.0)
        self._slice: Slice | None = None

    def velocity(self, view: View) -> Vector:
        """See `agents.laws.law.Law`."""
        position, goal, neighbours = view.position, view.goal, view.neighbours
        others = neighbours.disks()
        peers = [*others, *standing(self._room, view.things, *position)]
        aim = self._attraction.aim(position, goal, view.things)
        self._aim, goal = (goal, aim), aim
        field = self._slice = Slice(
            goal, self._radius, self._workspace, grown(self._k, self._robots, len(others) + 1), peers
        )
        begin = field.gradient(*position)
        moving = neighbours.moving()
        away = math.hypot(position[0] - goal[0], position[1] - goal[1])
        scale = self._scale(math.hypot(begin.dx, begin.dy), away, moving)
        free = self._free(away, scale)
        strength = self._stuck(view, goal, away, free, peers, moving)
        self._wanted = self._follow(Flow(field, scale), position, begin)
        if strength == 0.0:
            return self._wanted
        vx, vy = circling(position, goal, self._radius, peers)
        drift = (strength * free * vx, strength * free * vy)
        return self._follow(Flow(field, scale, drift), position, begin)

    def slice_norm(self, position: Vector, goal: Vector) -> float:
        """See `agents.laws.law.Law`; before the first tick the attraction alone."""
        if self._slice is None:
            return 2.0 * math.hypot(position[0] - goal[0], position[1] - goal[1])
        self._slice.goal = self._aim[1] if goal == self._aim[0] else goal
        return self._slice.norm(*position)

    def _follow(self, flow: Flow, position: Vector, begin: Gradient) -> Vector:
        return desired_velocity(flow, position, period=self._period, speed=self._speed, begin=begin)

    def _scale(self, slice_norm: float, away: float, moving: Sequence[PeerState]) -> float:
        if not self._common:
            return pace.own_pace(self._max_rate)
        gamma = away**2
        for state in moving:
            slice_norm, gamma = max(slice_norm, state.slice), max(gamma, state.gamma)
        return pace.common_pace(slice_norm, gamma, self._speed, self._max_rate)

    def _stuck(
        self,
        view: View,
        goal: Vector,
        away: float,
        free: float,
        peers: list[Peer],
        moving: Sequence[PeerState],
    ) -> float:
        """How strongly to escape from a deadlock, 0 to 1."""
        if self._progress is None:
            return 0.0
        gamma, oldest = 0.0, view.tick
        for peer in peers:
            gamma += peer.gamma
        for state in moving:
            oldest = min(oldest, state.tick)
        return self._progress.update(
            displacement=view.displacement,
            desired=self._wanted,
            free=free,
            gamma=away**2 + gamma,
            barred=lambda: barred(view.position, goal, self._radius, peers),
            latency=(view.tick - oldest) * self._period,
        )

    def _free(self, away: float, scale: float) -> float:
        """Speed that attraction alone would give, m/s; 0 at the goal."""
        return min(self._speed, 2.0 * scale * away) if away > self._tolerance else 0.0
