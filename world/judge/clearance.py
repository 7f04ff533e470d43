"""Clearance: the gap between any two disks, and between a disk and what surrounds it, over continuous time.

Positions are complex numbers x + iy, shape (..., p), in the order of robot ids; pairs are i < j,
shape (..., q): any number of ticks may be measured at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy

import numpy as np
from numpy.typing import NDArray

from protocol.geometry import Shape
from protocol.scenario.model import Scenario
from world.judge.surroundings import Surroundings, closest

Reals = NDArray[np.float64]
Plane = NDArray[np.complex128]
Indices = NDArray[np.intp]


class Disks:
    """The disks of a scenario, and which of them can touch.

    Attributes:
        ids: robot ids in increasing order, p of them.
        first, second: index of either robot of each pair.
        contact: distance at which each pair touches, rho_ij, m.
        surroundings: the boundary and the things.
    """

    def __init__(self, scenario: Scenario) -> None:
        specs = sorted(scenario.robots, key=lambda spec: spec.id)
        radii = np.array([spec.radius for spec in specs])
        self.ids = tuple(spec.id for spec in specs)
        self.first, self.second = np.triu_indices(len(specs), 1)
        self.contact: Reals = radii[self.first] + radii[self.second]
        self.surroundings = Surroundings(scenario.workspace.shape, scenario.shapes, radii)

    def surround(self, things: Mapping[int, Shape]) -> None:
        """Other things stand now, by number."""
        self.surroundings = Surroundings(self.surroundings.room, things, self.surroundings.radii)

    def only(self, first: Indices, second: Indices) -> Disks:
        """The same disks, and of all pairs these, by the indices of either robot."""
        few, radii = copy(self), self.surroundings.radii
        few.first, few.second = first, second
        few.contact = radii[first] + radii[second]
        return few

    def __len__(self) -> int:
        """Number of gaps of a configuration."""
        return len(self.contact) + len(self.surroundings)

    def relative(self, positions: Plane) -> Plane:
        """Relative position d_ij = b_i - b_j of each pair, shape (..., q)."""
        relative: Plane = positions[..., self.first] - positions[..., self.second]
        return relative

    def names(self, index: int) -> tuple[int, int]:
        """Ids of the two that gap `index` of `gaps` is between; 0 is the boundary, -n is thing n."""
        pairs = len(self.contact)
        if index < pairs:
            return (self.ids[self.first[index]], self.ids[self.second[index]])
        thing, robot = divmod(index - pairs, len(self.ids))
        return (-self.surroundings.numbers[thing - 1] if thing else 0, self.ids[robot])


def gaps(disks: Disks, before: Plane, after: Plane) -> Reals:
    """Smallest gap of each pair, then of each robot to the boundary and to things, during straight motion at
    constant speed from `before` to `after`; negative is overlap. Shape (..., len(disks)), m.

    The distance of a pair is smallest where its relative motion, a straight line, is nearest to the origin.
    """
    start = disks.relative(before)
    to_others = closest(start, disks.relative(after) - start) - disks.contact
    return np.concatenate((to_others, disks.surroundings.gaps(before, after)), axis=-1)
