"""The paper's law with additions, each of which `control.additions` may omit.

In the order in which they act in a tick:
- obstacles: static obstacles and straight walls repel, and the attraction follows the path around them.
- jams: a robot that blocks others backs off for a while.
- late-states: peers are extrapolated, and gain and speed near the goal adapt to late States.
- pace: all robots use one common scale s, so that the path is the paper's.
- escape: a robot without progress drifts along the direction of negative curvature.
Without any it is `agents.law.gradient.GradientLaw`, to the last bit.
"""

from __future__ import annotations

import math

from agents.law import pace
from agents.law.api import View
from agents.law.deadlock import Progress, barred, circling
from agents.law.flow import Flow, desired_velocity
from agents.law.gradient import Gradient, Slice, boundary_radius
from agents.law.jams import GivingWay
from agents.law.late_states import foreseen, late_gain, late_speed
from agents.law.obstacles import Attraction
from agents.peers.far import NOTHING
from agents.peers.state import Peer, PeerState
from protocol.messages import Vector
from protocol.scenario.model import Scenario, gain_for_fleet


class AugmentedLaw:
    """One robot's slice of the gradient with the additions of the scenario: a `Law`."""

    def __init__(self, scenario: Scenario, robot: int) -> None:
        spec, control, additions = scenario.spec(robot), scenario.control, scenario.control.additions
        self._radius = spec.radius
        self._room, self._k, self._robots = scenario.workspace.shape, scenario.k, len(scenario.robots)
        self._workspace = boundary_radius(self._room)
        self._speed, self._period = control.speed, scenario.time.step
        self._tolerance = scenario.time.tolerance
        self._max_rate = pace.max_rate(control.speed, scenario.time.step, scenario.time.tolerance)
        self._lap = max(each.radius for each in scenario.robots) / control.speed
        self._common = "pace" in additions
        self._adapts = "late-states" in additions
        self._attraction: Attraction | None = None
        if "obstacles" in additions:
            self._attraction = Attraction(self._room, spec.radius, alone=len(scenario.robots) == 1)
            shapes = tuple(scenario.shapes.values())
            self._attraction.repelling(spec.start, shapes)
            self._attraction.aim(spec.start, spec.goal, shapes)  # map and path may take longer than a tick
        self._progress = Progress(scenario.time.step, self._lap) if "escape" in additions else None
        self._jams: GivingWay | None = None
        if "jams" in additions:
            self._jams = GivingWay(robot, spec.radius, self._lap, scenario.time.step)
        self._yields = False
        self._wanted: Vector = (0.0, 0.0)
        self._slice = Slice(spec.goal, spec.radius, self._workspace, math.inf, [])  # the attraction alone
        # Of the present tick, set by `look`.
        self.aim = self._goal = spec.goal  # point of attraction, m
        # Length of the straight first part of the path there, m; infinite if it does not turn.
        self.straight = math.inf
        self.obstacles: list[Peer] = []  # static ones, as disks
        self.disks: list[Peer] = []  # peers as received, and static disks
        self._peers: list[Peer] = []
        self._moving: list[PeerState] = []
        self._far = NOTHING
        self._begin = Gradient(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        self._distance = self._scale = self._free = 0.0
        self._latency = 0.0  # s, age of the oldest State of a moving peer
        self._late = 0  # ticks since the summary of far peers

    def velocity(self, view: View) -> Vector:
        """Desired velocity, m/s."""
        self.look(view)
        strength = self.stuck(view, self._wanted)
        self._wanted = self.flow(view, 0.0)
        return self._wanted if strength == 0.0 else self.flow(view, strength)

    def look(self, view: View) -> None:
        """Update from a tick's view; called first in each tick."""
        x, y = view.position
        attraction = self._attraction
        self.obstacles = [] if attraction is None else attraction.repelling(view.position, view.obstacles)
        self.disks, self._moving = view.neighbours.disks(), view.neighbours.moving()
        oldest = view.tick
        for state in self._moving:
            oldest = min(oldest, state.tick)
        self._latency = (view.tick - oldest) * self._period
        if view.goal != self._goal and self._progress is not None:
            self._progress = Progress(self._period, self._progress.lap)  # the old goal's deadlock is over
        self._goal, self.aim = view.goal, self._aim(view)
        self.straight = math.inf if self._attraction is None else self._attraction.straight
        self._far = view.neighbours.far
        self._late = view.tick - self._far.tick
        k = gain_for_fleet(self._k, self._robots, len(self.disks) + self._far.count + 1)
        gx, gy = self.aim
        self._distance = math.hypot(x - gx, y - gy)
        others = self.disks
        if self._adapts and self._latency > 0.0:
            me = Peer(x, y, self._radius, math.dist(view.position, view.goal) ** 2)
            others = foreseen(me, others, view.tick, self._period, self._lap)
            k = late_gain(k, self._distance / self._radius, self._latency / self._lap)
        self._peers = [*others, *self.obstacles]
        self._slice = Slice(self.aim, self._radius, self._workspace, k, self._peers, self._far)
        self._begin = self._slice.gradient(x, y)
        self._scale = self._pace(math.hypot(self._begin.dx, self._begin.dy))
        free = min(self._speed, 2.0 * self._scale * self._distance)
        self._free = free if self._distance > self._tolerance else 0.0

    def _aim(self, view: View) -> Vector:
        """Point of attraction: the goal, or the place to back off to."""
        jams = self._jams
        if jams is None:
            return self._along(view, view.goal)
        if self._winds:
            jams.let_pass(view.tick, view.position, self._moving)
        back = jams.yielding(view.tick, view.goal)
        self._yields = back is not None
        if back is not None:
            return self._along(view, back)
        aim = self._along(view, view.goal)
        left = math.dist(view.position, aim)
        if self._winds:
            if left > self._tolerance:
                jams.look_in_passages(view.tick, view.position, left, self._moving, view.obstacles)
        elif self._progress is not None:
            stuck = self._progress.strength > 0.0
            jams.look_in_the_open(view.tick, view.position, left, self._moving, stuck=stuck)
        return aim

    def _along(self, view: View, goal: Vector) -> Vector:
        """The point of attraction for a goal: as far as the goal along the path, straight ahead, m."""
        return goal if self._attraction is None else self._attraction.aim(view.position, goal, view.obstacles)

    @property
    def _winds(self) -> bool:
        return self._attraction is not None and self._attraction.winds

    def slice_norm(self, position: Vector, goal: Vector) -> float:
        """|D_i|, m; before the first tick that of the attraction alone."""
        self._slice.goal = self.aim if goal == self._goal else goal
        return self._slice.norm(*position)

    def flow(self, view: View, strength: float) -> Vector:
        """The flow's mean velocity over the period, m/s, with an escape of this `strength`, 0 to 1."""
        drift = (0.0, 0.0)
        if strength > 0.0:
            vx, vy = circling(view.position, self.aim, self._radius, self._peers)
            drift = (strength * self._free * vx, strength * self._free * vy)
        return desired_velocity(
            Flow(self._slice, self._scale, drift),
            view.position,
            period=self._period,
            speed=self._speed,
            begin=self._begin,
        )

    def stuck(self, view: View, wanted: Vector) -> float:
        """Strength of the escape from a deadlock, 0 to 1, after a desired velocity of `wanted` (m/s)."""
        if self._progress is None:
            return 0.0
        gamma = self._far.gamma
        for peer in self._peers:
            gamma += peer.gamma
        return self._progress.update(
            displacement=view.displacement,
            desired=wanted,
            free=self._free,
            gamma=self._distance**2 + gamma,
            barred=lambda: barred(view.position, self.aim, self._radius, self._peers),
            latency=self._latency,
        )

    def _pace(self, slice_norm: float) -> float:
        if not self._common or self._yields:  # a robot that backs off follows no path of the fleet
            return self._max_rate
        # The summary of far peers is old: reduce it by the motion since then.
        since = self._speed * self._period * self._late
        far = max(0.0, math.sqrt(self._far.largest) - since)
        gamma, slice_norm = max(self._distance**2, far * far), max(slice_norm, self._far.slice - 2.0 * since)
        for state in self._moving:
            slice_norm, gamma = max(slice_norm, state.slice), max(gamma, state.gamma)
        speed = self._speed
        if self._adapts:
            speed = late_speed(speed, self._distance / self._radius, self._latency / self._lap)
        return pace.common_pace(slice_norm, gamma, speed, self._max_rate)
