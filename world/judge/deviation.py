"""How far robots were ever moved aside: the largest distance of each from its straight way."""

from __future__ import annotations

import numpy as np

from world.judge.clearance import Plane
from world.judge.goals import Goals


class LateralDeviation:
    """Largest distance of each centre so far from the segment that is its straight way (`Goals`), m.

    Of a robot that starts at its goal, from there. A convex function of the place, so that between two
    ticks, in which robots move straight, it is nowhere larger than at both.
    """

    def __init__(self, goals: Goals) -> None:
        self._goals = goals
        self._ids = goals.ids
        self._largest = np.zeros(len(goals.ids))

    def recast(self) -> None:
        """The goals are those of other robots from now on."""
        known = dict(zip(self._ids, self._largest.tolist(), strict=True))
        self._ids = self._goals.ids
        self._largest = np.array([known.get(robot, 0.0) for robot in self._ids])

    def add(self, positions: Plane) -> None:
        """Configurations as complex numbers, shape (n, p), m."""
        begins = self._goals.begins
        ways = self._goals.points - begins
        lengths = np.abs(ways)
        # Factors that make every way run along the real axis.
        turns = np.divide(np.conj(ways), lengths, out=np.ones_like(ways), where=lengths > 0.0)
        turned = (positions - begins - 0.5 * ways) * turns
        along = np.maximum(np.abs(turned.real) - 0.5 * lengths, 0.0)
        np.maximum(self._largest, np.hypot(along, turned.imag).max(axis=0), out=self._largest)

    def __call__(self) -> list[float]:
        """In the order of ids, m."""
        found: list[float] = self._largest.tolist()
        return found
