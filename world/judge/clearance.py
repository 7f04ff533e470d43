"""Clearance: the gap between any two disks, and between a disk and the boundary, over continuous time.

Positions are complex numbers x + iy, shape (..., p), in the order of robot ids; pairs are i < j,
shape (..., q): any number of ticks may be measured at once.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from protocol.scenario.model import Scenario

Reals = NDArray[np.float64]
Plane = NDArray[np.complex128]

_TINY = np.finfo(np.float64).tiny


class Disks:
    """The disks of a scenario, and which of them can touch.

    Attributes:
        ids: robot ids in increasing order, p of them.
        first, second: index of either robot of each pair.
        contact: distance at which each pair touches, rho_ij, m.
        wall: distance from the origin at which each robot touches the boundary, rho_0i, m.
    """

    def __init__(self, scenario: Scenario) -> None:
        specs = sorted(scenario.robots, key=lambda spec: spec.id)
        radii = np.array([spec.radius for spec in specs])
        self.ids = tuple(spec.id for spec in specs)
        self.first, self.second = np.triu_indices(len(specs), 1)
        self.contact: Reals = radii[self.first] + radii[self.second]
        self.wall: Reals = scenario.workspace.radius - radii

    def relative(self, positions: Plane) -> Plane:
        """Relative position d_ij = b_i - b_j of each pair, shape (..., q)."""
        relative: Plane = positions[..., self.first] - positions[..., self.second]
        return relative

    def names(self, index: int) -> tuple[int, int]:
        """Ids of the two that gap `index` of `gaps` is between; 0 is the boundary."""
        pairs = len(self.contact)
        if index < pairs:
            return (self.ids[self.first[index]], self.ids[self.second[index]])
        return (0, self.ids[index - pairs])


def gaps(disks: Disks, before: Plane, after: Plane) -> Reals:
    """Smallest gap of each pair, then of each robot to the boundary, during straight motion at
    constant speed from `before` to `after`; negative is overlap. Shape (..., q + p), m.

    The distance of a pair is smallest where its relative motion, a straight line, comes nearest to
    the origin. The distance from the workspace centre is a convex function of time: it is largest at an end.
    """
    start = disks.relative(before)
    motion = disks.relative(after) - start
    squared = motion.real**2 + motion.imag**2
    along = start.real * motion.real + start.imag * motion.imag
    nearest = np.clip(-along / np.maximum(squared, _TINY), 0.0, 1.0)
    to_others = np.abs(start + nearest * motion) - disks.contact
    to_wall = disks.wall - np.maximum(np.abs(before), np.abs(after))
    return np.concatenate((to_others, to_wall), axis=-1)
