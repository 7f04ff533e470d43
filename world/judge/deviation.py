"""How far robots were ever moved aside: the largest distance of each from its straight way."""

from __future__ import annotations

import numpy as np

from protocol.scenario.model import Scenario
from world.judge.clearance import Plane


class LateralDeviation:
    """Largest distance of each centre so far from the segment between its start and its goal, m.

    Of a robot that starts at its goal, from there. A convex function of the place, so that between two
    ticks, in which robots move straight, it is nowhere larger than at both.
    """

    def __init__(self, scenario: Scenario) -> None:
        specs = [scenario.spec(robot) for robot in scenario.ids]
        starts: Plane = np.array([complex(*spec.start) for spec in specs])
        ways: Plane = np.array([complex(*spec.goal) for spec in specs]) - starts
        lengths = np.abs(ways)
        self._halves = 0.5 * lengths
        self._middles = starts + 0.5 * ways
        # Factors that make every way run along the real axis.
        self._turns = np.divide(np.conj(ways), lengths, out=np.ones_like(ways), where=lengths > 0.0)
        self._largest = np.zeros(len(specs))

    def add(self, positions: Plane) -> None:
        """Configurations as complex numbers, shape (n, p), m."""
        turned = (positions - self._middles) * self._turns
        along = np.maximum(np.abs(turned.real) - self._halves, 0.0)
        np.maximum(self._largest, np.hypot(along, turned.imag).max(axis=0), out=self._largest)

    def __call__(self) -> list[float]:
        """In the order of ids, m."""
        found: list[float] = self._largest.tolist()
        return found
