"""Where every robot is to be: the one place that verdict, phi, deviation and measures take goals from."""

from __future__ import annotations

import numpy as np

from protocol.messages import Vector
from protocol.scenario.model import Scenario
from world.judge.clearance import Plane


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
