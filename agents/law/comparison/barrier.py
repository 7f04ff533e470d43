"""A barrier-function quadratic program (Wang, Ames, Egerstedt 2017) by daqp, to compare with.

The velocity nearest to the nominal one under h' >= -gain h for every h of
    h_ij = |d_ij|^2 - rho_ij^2   of a peer, which is taken to answer for half of it,
    h_0i = rho_0i^2 - |b_i|^2    of a round boundary,
    |x - q|^2 - rho_i^2          of a straight wall or a thing, q its nearest point (of a disk as of a peer).
Peers stand where their newest State says, moved on by their velocity over its age. While every h >= 0 the
velocity 0 is feasible, so the nearest velocity is never faster than the nominal one.
`control.barrier_gain`, `symmetry_noise` and `margin` outrank the constants below.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from agents.law.api import Law, View
from agents.law.comparison.nominal import Nominal
from agents.law.gradient import boundary_radius
from agents.law.obstacles import obstacle_disks
from agents.lines.boundary import boundary_of
from agents.lines.safe_velocity import safe_velocity
from protocol.messages import Vector
from protocol.scenario.model import Scenario

Array = NDArray[np.float64]

GAIN = 4.0  # 1/s
NOISE = 0.1  # of the speed limit
MARGIN = 0.0005  # m, around each disk


class BarrierLaw(Law):
    """One robot's share of the program; see `agents.law.api.Law`."""

    def __init__(self, scenario: Scenario, robot: int) -> None:
        from daqp import solve

        control = scenario.control
        margin = MARGIN if control.margin is None else control.margin
        self._solve = solve
        self._speed, self._period = control.speed, scenario.time.step
        self._gain = GAIN if control.barrier_gain is None else control.barrier_gain
        self._room = scenario.workspace.shape
        self._reach = boundary_radius(self._room) - scenario.spec(robot).radius
        self._boundary = boundary_of(self._room, scenario.spec(robot).radius)
        self._radius = scenario.spec(robot).radius + margin
        self._radii = {spec.id: spec.radius + margin for spec in scenario.robots if spec.id != robot}
        self._nominal = Nominal(
            scenario, robot, NOISE if control.symmetry_noise is None else control.symmetry_noise
        )

    def velocity(self, view: View) -> Vector:
        """See `agents.law.api.Law`; stands still where the program has no solution."""
        wanted = np.array(self._nominal.velocity(view.position, view.goal, view.tick, view.things))
        normals, upper = self._barriers(np.array(view.position), view)
        if (normals @ wanted > upper).any():
            lower, hard = np.full(len(upper), -1e30), np.zeros(len(upper), dtype=np.int32)
            wanted, _, flag, _ = self._solve(np.eye(2), -wanted, normals, upper, lower, hard)
            if flag != 1:
                return 0.0, 0.0
        vx, vy = float(wanted[0]), float(wanted[1])
        excess = max(1.0, math.hypot(vx, vy) / self._speed)
        return self._inside(view.position, (vx / excess, vy / excess))

    def _barriers(self, own: Array, view: View) -> tuple[Array, Array]:
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
        for disk in obstacle_disks(self._room, view.things, *view.position):
            apart = own - np.array((disk.x, disk.y))
            rows.append(-apart)
            limits.append(0.5 * self._gain * (float(apart @ apart) - (disk.radius + self._radius) ** 2))
        normals, upper = np.array(rows), np.array(limits)
        lengths = np.maximum(np.hypot(normals[:, 0], normals[:, 1]), 1e-9)
        return normals / lengths[:, None], upper / lengths

    def _inside(self, position: Vector, velocity: Vector) -> Vector:
        """The boundary curves towards a robot that moves along it: the nearest velocity that stays inside."""
        return safe_velocity(
            velocity, position, (), boundary=self._boundary, speed=self._speed, period=self._period
        )
