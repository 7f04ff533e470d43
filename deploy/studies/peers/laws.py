"""Laws for comparison, loaded as `control.law = "deploy.studies.peers.laws:Orca(horizon=2.0)"`.

- `Orca`: optimal reciprocal collision avoidance (van den Berg, Guy, Lin, Manocha 2011), by pyrvo.
- `Barrier`: a barrier-function quadratic program (Wang, Ames, Egerstedt 2017), by daqp.

Their nominal velocity points straight to the goal, or along the shortest path among static obstacles, plus a
random part. Peers are extrapolated from their newest States by their velocity.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from importlib.util import find_spec

import numpy as np

from agents.law import View
from agents.law.gradient import boundary_radius
from agents.law.obstacles import Attraction, obstacle_disks
from agents.lines.boundary import boundary_of
from agents.lines.safe_velocity import Limits, safe_velocity
from agents.peers.neighbours import Neighbours
from protocol.arrays import Reals
from protocol.draws import Purpose, generator
from protocol.geometry import Shape
from protocol.messages import Vector
from protocol.process.installation import missing_library
from protocol.scenario.model import Scenario

_HELD = 1.0  # s between draws of the random part, which would average out if drawn every tick
_WALL = 2.0  # ORCA's horizon for the boundary, periods; more slows the approach to goals beside it


class Nominal:
    """Straight to the goal at the speed limit, slower in the last period, plus a random part.

    Without the random part both laws are known not to resolve symmetric encounters.

    Args:
        noise: largest random velocity, as a fraction of the speed limit; 0 at the goal.
    """

    def __init__(self, scenario: Scenario, robot: int, noise: float) -> None:
        self._robot, self._seed = robot, scenario.seed
        self._speed, self._period = scenario.control.speed, scenario.time.step
        self._held = max(1, scenario.ticks(_HELD))
        self._tolerance, self._noise = scenario.time.tolerance, noise
        self._attraction = Attraction(
            scenario.workspace.shape, scenario.spec(robot).radius, alone=len(scenario.robots) == 1
        )

    def velocity(self, view: View) -> Vector:
        """Velocity, m/s; the random part may exceed the speed limit."""
        goal = self._attraction.aim(view.position, view.goal, view.obstacles)
        dx, dy = goal[0] - view.position[0], goal[1] - view.position[1]
        distance = math.hypot(dx, dy)
        if distance <= 0.5 * self._tolerance:
            return 0.0, 0.0
        rate = min(self._speed / distance, 1.0 / self._period)
        draw = generator(self._seed, Purpose.CONTROL, self._robot, view.tick // self._held)
        angle, size = math.tau * draw.random(), self._noise * self._speed * draw.random()
        return rate * dx + size * math.cos(angle), rate * dy + size * math.sin(angle)


class Orca:
    """Optimal reciprocal collision avoidance of one robot: a `Law`.

    Every robot has its own simulator, fed with the States that it received, of which only its own new
    velocity is used.

    Args:
        horizon: time ahead, s, in which encounters are considered.
        noise: largest random part of the nominal velocity, as a fraction of the speed limit.
        margin: added to each radius, m, since ORCA plans to touch exactly, in single precision.

    Raises:
        UsageError: pyrvo is not installed.
    """

    def __init__(
        self,
        scenario: Scenario,
        robot: int,
        *,
        horizon: float = 2.0,
        noise: float = 0.1,
        margin: float = 0.001,
    ) -> None:
        _require("Orca", "pyrvo")
        self._horizon, self._period, self._speed = horizon, scenario.time.step, scenario.control.speed
        self._radii = {spec.id: spec.radius + margin for spec in scenario.robots}
        self._robot, self._room = robot, scenario.workspace.shape
        self._nominal = Nominal(scenario, robot, noise)
        self._reset(())

    def velocity(self, view: View) -> Vector:
        """Velocity, m/s. Changed obstacles need a new simulator."""
        if self._obstacles != list(view.obstacles):
            self._reset(view.obstacles)
        moving = (view.displacement[0] / self._period, view.displacement[1] / self._period)
        self._place(self._own, view.position, moving, self._nominal.velocity(view))
        for peer in self._radii:
            self._observe(peer, view.neighbours, view.tick)
        self._simulator.do_step()
        new = self._simulator.get_agent_velocity(self._own)
        excess = max(1.0, math.hypot(new.x, new.y) / self._speed)
        return new.x / excess, new.y / excess

    def _reset(self, obstacles: Sequence[Shape]) -> None:
        from pyrvo import RVOSimulator

        self._obstacles, self._agents = list(obstacles), dict[int, int]()
        self._simulator = RVOSimulator(
            self._period,
            2.0 * self._room.around.radius,
            len(self._radii),
            self._horizon,
            _WALL * self._period,
            self._radii[self._robot],
            self._speed,
        )
        first, *others = self._room.outline()
        self._simulator.add_obstacle([first, *reversed(others)])  # clockwise: robots are kept inside
        for shape in obstacles:
            self._simulator.add_obstacle(shape.outline())
        self._simulator.process_obstacles()
        self._own = self._simulator.add_agent((0.0, 0.0))

    def _observe(self, peer: int, neighbours: Neighbours, tick: int) -> None:
        place = neighbours.position(peer)
        if place is None:
            return
        if peer not in self._agents:
            agent = self._agents[peer] = self._simulator.add_agent(place)
            self._simulator.set_agent_radius(agent, self._radii[peer])
            self._simulator.set_agent_max_neighbors(agent, 0)  # the simulator does not plan for peers
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


class Barrier:
    """Barrier-function program of one robot: a `Law`.

    The velocity nearest to the nominal one under h' >= -gain h for every h of
        h_ij = |d_ij|^2 - rho_ij^2   of a peer, which is assumed to keep half of the constraint,
        h_0i = rho_0i^2 - |b_i|^2    of a round boundary,
        |x - q|^2 - rho_i^2          of a straight wall or an obstacle, q its nearest point.
    An obstacle that is a disk is a peer. While every h >= 0 the velocity 0 is feasible, so the nearest
    velocity is never faster than the nominal one.

    Args:
        gain: 1/s.
        noise: largest random part of the nominal velocity, as a fraction of the speed limit.
        margin: added to each radius, m.

    Raises:
        UsageError: daqp is not installed.
    """

    def __init__(
        self,
        scenario: Scenario,
        robot: int,
        *,
        gain: float = 4.0,
        noise: float = 0.1,
        margin: float = 0.0005,
    ) -> None:
        _require("Barrier", "daqp")
        from daqp import solve

        self._solve = solve
        self._gain, self._speed, self._period = gain, scenario.control.speed, scenario.time.step
        self._room, radius = scenario.workspace.shape, scenario.spec(robot).radius
        self._reach = boundary_radius(self._room) - radius
        self._boundary = boundary_of(self._room, radius)
        self._radius = radius + margin
        self._radii = {spec.id: spec.radius + margin for spec in scenario.robots if spec.id != robot}
        self._nominal = Nominal(scenario, robot, noise)

    def velocity(self, view: View) -> Vector:
        """Velocity, m/s; 0 if the program has no solution."""
        wanted = np.array(self._nominal.velocity(view))
        normals, upper = self._barriers(np.array(view.position), view)
        if (normals @ wanted > upper).any():
            lower, hard = np.full(len(upper), -1e30), np.zeros(len(upper), dtype=np.int32)
            wanted, _, flag, _ = self._solve(np.eye(2), -wanted, normals, upper, lower, hard)
            if flag != 1:
                return 0.0, 0.0
        vx, vy = float(wanted[0]), float(wanted[1])
        excess = max(1.0, math.hypot(vx, vy) / self._speed)
        # The boundary curves towards a robot that moves along it: the nearest velocity that stays inside.
        limits = Limits(view.position, (), [self._boundary], None)
        return safe_velocity((vx / excess, vy / excess), limits, speed=self._speed, period=self._period)

    def _barriers(self, own: Reals, view: View) -> tuple[Reals, Reals]:
        """Rows a and limits c of a . v <= c, scaled to |a| = 1 so that the solver's tolerance is a speed."""
        neighbours, tick = view.neighbours, view.tick
        rows, limits = [own], [0.5 * self._gain * (self._reach**2 - float(own @ own))]
        for peer, radius in self._radii.items():
            place = neighbours.position(peer)
            if place is None:
                continue
            apart, share = own - np.array(place), 1.0
            state = None if peer in neighbours.standing else neighbours.state(peer)
            if state is not None:
                share = 0.5
                apart -= (tick - state.tick) * self._period * np.array(state.desired)
            rows.append(-apart)
            limits.append(0.5 * share * self._gain * (float(apart @ apart) - (radius + self._radius) ** 2))
        for disk in obstacle_disks(self._room, view.obstacles, *view.position):
            apart = own - np.array((disk.x, disk.y))
            rows.append(-apart)
            limits.append(0.5 * self._gain * (float(apart @ apart) - (disk.radius + self._radius) ** 2))
        normals, upper = np.array(rows), np.array(limits)
        lengths = np.maximum(np.hypot(normals[:, 0], normals[:, 1]), 1e-9)
        return normals / lengths[:, None], upper / lengths


def _require(law: str, library: str) -> None:
    if find_spec(library) is None:
        raise missing_library(f'control.law = "{__name__}:{law}"', library, "peers")
