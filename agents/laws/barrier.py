"""A barrier-function quadratic program (Wang, Ames, Egerstedt 2017) by daqp, to compare with.

The velocity nearest to the nominal one under h' >= -gain h for every h of
    h_ij = |d_ij|^2 - rho_ij^2   of a peer, which is taken to answer for half of it,
    h_0i = rho_0i^2 - |b_i|^2    of the boundary.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from agents.laws.nominal import Nominal
from agents.neighbours import Neighbours
from protocol.scenario import Scenario

Vector = tuple[float, float]

GAIN = 4.0  # 1/s
NOISE = 0.1  # of the speed limit
_SIDES = 16  # of the polygon inside the disk of speeds


class BarrierLaw:
    """One robot's share of the program; see `agents.laws.law.Law`."""

    def __init__(self, scenario: Scenario, robot: int) -> None:
        from daqp import solve

        self._solve = solve
        self._speed, self._radius = scenario.control.speed, scenario.spec(robot).radius
        self._room = scenario.workspace.radius - self._radius
        self._radii = {spec.id: spec.radius for spec in scenario.robots if spec.id != robot}
        self._nominal = Nominal(scenario, robot, NOISE)
        angles = math.tau * np.arange(_SIDES) / _SIDES
        self._sides = np.column_stack([np.cos(angles), np.sin(angles)])
        self._reach = np.full(_SIDES, self._speed * math.cos(math.pi / _SIDES))

    def velocity(self, position: Vector, displacement: Vector, neighbours: Neighbours, tick: int) -> Vector:  # noqa: ARG002
        """See `agents.laws.law.Law`; stands still where the program has no solution."""
        wanted = np.array(self._nominal.velocity(position, tick))
        rows, limits = self._barriers(np.array(position), neighbours)
        normals = np.vstack([self._sides, *rows])
        upper = np.concatenate([self._reach, limits])
        lower = np.full(len(upper), -1e30)
        found, _, flag, _ = self._solve(
            np.eye(2), -wanted, normals, upper, lower, np.zeros(len(upper), dtype=np.int32)
        )
        return (float(found[0]), float(found[1])) if flag == 1 else (0.0, 0.0)

    def slice_norm(self, position: Vector) -> float:
        """See `agents.laws.law.Law`."""
        return self._nominal.pull(position)

    def _barriers(
        self, own: NDArray[np.float64], neighbours: Neighbours
    ) -> tuple[list[NDArray[np.float64]], list[float]]:
        """Rows a and limits c of a . v <= c, scaled to |a| = 1 so that the solver's tolerance is a speed."""
        rows, limits = [own], [0.5 * GAIN * (self._room**2 - float(own @ own))]
        for peer, radius in self._radii.items():
            place = neighbours.position(peer)
            if place is None:
                continue
            apart = own - np.array(place)
            share = 0.5 if peer not in neighbours.down else 1.0
            rows.append(-apart)
            limits.append(0.5 * share * GAIN * (float(apart @ apart) - (radius + self._radius) ** 2))
        lengths = [max(float(np.hypot(*row)), 1e-9) for row in rows]
        return (
            [row / length for row, length in zip(rows, lengths, strict=True)],
            [limit / length for limit, length in zip(limits, lengths, strict=True)],
        )
