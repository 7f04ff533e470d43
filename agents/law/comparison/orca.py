"""Optimal reciprocal collision avoidance (van den Berg, Guy, Lin, Manocha 2011) by pyrvo, to compare with.

Every robot has a simulator of its own, fed with what that robot heard: peers stand where their newest
State says, moved on by their velocity over its age. Only the robot's own new velocity is used.
`control.horizon`, `symmetry_noise` and `margin` outrank the constants below.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from agents.law.api import Law, View
from agents.law.comparison.nominal import Nominal
from agents.peers.neighbours import Neighbours
from protocol.geometry import Shape
from protocol.messages import Vector
from protocol.scenario.model import Scenario

HORIZON = 2.0  # s, ahead of which encounters count
NOISE = 0.1  # of the speed limit
MARGIN = 0.001  # m, around each disk: reciprocal velocities plan to touch exactly, in single precision
_WALL = 2.0  # periods ahead of which the boundary counts: more only slows the way to goals beside it


class OrcaLaw(Law):
    """One robot's reciprocal velocity; see `agents.law.api.Law`."""

    def __init__(self, scenario: Scenario, robot: int) -> None:
        control = scenario.control
        self._horizon = HORIZON if control.horizon is None else control.horizon
        margin = MARGIN if control.margin is None else control.margin
        self._period, self._speed = scenario.time.step, control.speed
        self._radii = {spec.id: spec.radius + margin for spec in scenario.robots}
        self._robot, self._room = robot, scenario.workspace.shape
        self._nominal = Nominal(
            scenario, robot, NOISE if control.symmetry_noise is None else control.symmetry_noise
        )
        self._begin(())

    def _begin(self, things: Sequence[Shape]) -> None:
        """A simulator with these things; what stands in one cannot be changed."""
        from pyrvo import RVOSimulator

        self._things, self._agents = list(things), dict[int, int]()
        everyone, far = len(self._radii), 2.0 * self._room.around.radius
        self._simulator = RVOSimulator(
            self._period,
            far,
            everyone,
            self._horizon,
            _WALL * self._period,
            self._radii[self._robot],
            self._speed,
        )
        first, *others = self._room.outline()
        self._simulator.add_obstacle([first, *reversed(others)])  # clockwise: robots are kept inside
        for shape in things:
            self._simulator.add_obstacle(shape.outline())
        self._simulator.process_obstacles()
        self._own = self._simulator.add_agent((0.0, 0.0))

    def velocity(self, view: View) -> Vector:
        """See `agents.law.api.Law`."""
        if self._things != list(view.things):
            self._begin(view.things)
        moving = (view.displacement[0] / self._period, view.displacement[1] / self._period)
        preferred = self._nominal.velocity(view.position, view.goal, view.tick, view.things)
        self._place(self._own, view.position, moving, preferred)
        for peer in self._radii:
            self._observe(peer, view.neighbours, view.tick)
        self._simulator.do_step()
        new = self._simulator.get_agent_velocity(self._own)
        excess = max(1.0, math.hypot(new.x, new.y) / self._speed)
        return new.x / excess, new.y / excess

    def _observe(self, peer: int, neighbours: Neighbours, tick: int) -> None:
        """Put a peer where it should be by now."""
        place = neighbours.position(peer)
        if place is None:
            return
        if peer not in self._agents:
            agent = self._agents[peer] = self._simulator.add_agent(place)
            self._simulator.set_agent_radius(agent, self._radii[peer])
            self._simulator.set_agent_max_neighbors(agent, 0)  # what a peer will do is not asked
        vx, vy = 0.0, 0.0
        state = None if peer in neighbours.standing else neighbours.state(peer)
        if state is not None:
            vx, vy = state.desired
            age = (tick - state.tick) * self._period
            place = (place[0] + age * vx, place[1] + age * vy)
        self._place(self._agents[peer], place, (vx, vy), (vx, vy))

    def _place(self, agent: int, position: Vector, velocity: Vector, preferred: Vector) -> None:
        simulator = self._simulator
        simulator.set_agent_position(agent, position)
        simulator.set_agent_velocity(agent, velocity)
        simulator.set_agent_pref_velocity(agent, preferred)
