"""Where every robot is to be, and how the ways there are measured (Karagoz, Bozma, Koditschek, section 4).

The one place that verdict, phi and measures take goals from.
"""

from __future__ import annotations

import math

import numpy as np

from protocol.messages import Vector
from protocol.scenario.model import Scenario
from world.judge.clearance import Disks, Plane

_CENTIMETRES = 100.0


class Goals:
    """Goals and straight ways, as complex numbers x + iy in the order of ids, m.

    Attributes:
        ids: robot ids in increasing order, p of them.
        points: present goals, shape (p,).
        begins: where the straight way to the present goal begins, shape (p,).
    """

    def __init__(self, scenario: Scenario) -> None:
        self.ids = scenario.ids
        specs = [scenario.spec(robot) for robot in self.ids]
        self.points: Plane = np.array([complex(*spec.goal) for spec in specs])
        self.begins: Plane = np.array([complex(*spec.start) for spec in specs])
        self._behind = 0.0  # m, of straight ways that another goal has ended

    def change(self, robot: int, goal: Vector, position: Vector) -> None:
        """From `position` (m) on a robot is to go to `goal` (m): its straight way so far ends there.

        Raises:
            KeyError: unknown id.
        """
        if robot not in self.ids:
            raise KeyError(robot)
        index = self.ids.index(robot)
        self._behind += float(abs(complex(*position) - self.begins[index]))
        self.begins[index], self.points[index] = complex(*position), complex(*goal)

    def recast(self, scenario: Scenario) -> None:
        """Robots came and went: a new one's straight way begins at its start, that of one that left is behind
        up to where its goal was."""
        ways = dict(zip(self.ids, zip(self.points.tolist(), self.begins.tolist(), strict=True), strict=True))
        self._behind += sum(
            abs(point - begin) for robot, (point, begin) in ways.items() if robot not in scenario.ids
        )
        for spec in scenario.robots:
            ways.setdefault(spec.id, (complex(*spec.goal), complex(*spec.start)))
        self.ids = scenario.ids
        self.points = np.array([ways[robot][0] for robot in self.ids])
        self.begins = np.array([ways[robot][1] for robot in self.ids])

    @property
    def straight(self) -> float:
        """Length of all straight ways so far, the present ones to their goals, m."""
        return self._behind + float(np.abs(self.points - self.begins).sum())


def tight(disks: Disks, goals: Goals) -> float | None:
    """Tightness of the goals: 100 / log10 of the product over pairs of |g_ij|^2 - rho_ij^2, in cm.

    None where the measure has no meaning: fewer than two robots, goals that touch or overlap, or
    goals so close that the logarithm is not positive.
    """
    apart = disks.relative(goals.points)
    factors = _CENTIMETRES**2 * (apart.real**2 + apart.imag**2 - disks.contact**2)
    if (factors <= 0.0).any():
        return None
    total = math.fsum(math.log10(factor) for factor in factors)
    return 100.0 / total if total > 0.0 else None


def normalised_length(goals: Goals, lengths: dict[int, float]) -> float | None:
    """nrl: path lengths (m, by robot id) over straight distances to the goals, summed over robots.

    None when every robot starts at its goal.
    """
    straight = goals.straight
    return math.fsum(lengths.values()) / straight if straight > 0.0 else None


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
