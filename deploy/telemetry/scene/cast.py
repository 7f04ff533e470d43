"""Who is there in a run, as its truths say, and what is known of each: by scenario, orders and rosters."""

from __future__ import annotations

import math
from collections.abc import Iterable, Set
from typing import NamedTuple

from protocol.messages import Member, Truth, Vector
from protocol.scenario.model import Scenario


class Changes(NamedTuple):
    """Who came, and who went."""

    came: Set[int]
    went: Set[int]


_NO_CHANGES = Changes(frozenset(), frozenset())


class Cast:
    """Those whose disks are there. Who was added by an operator is one of them once somebody says its size.

    Attributes:
        radii: m, of those who are there, or of whom a roster spoke.
        goals: m, where those go who are there, as far as somebody said so: no roster does.
        strangers: whose disks are there, and of whom nothing is known.
    """

    def __init__(self, scenario: Scenario) -> None:
        specs = [scenario.spec(robot) for robot in scenario.ids]
        self._newcomers = scenario.newcomers
        self.radii = {spec.id: spec.radius for spec in specs}
        self.goals = {spec.id: spec.goal for spec in specs}
        self._places = {spec.id: spec.start for spec in specs}
        self._truth = Truth(0, scenario.ids, tuple(self._places.values()), 0.0, 1.0)
        self._told = scenario.ids  # by the newest truth
        self.strangers: Set[int] = frozenset()

    @property
    def places(self) -> dict[int, Vector]:
        """Where those are who are there, ascending, m; at their starts before the first truth."""
        told = zip(self._truth.robots, self._truth.positions, strict=False)
        self._places.update((robot, place) for robot, place in told if robot in self._places)
        return self._places

    def meet(self, scenario: Scenario) -> None:
        """Take over what is said of strangers by the scenario as the world has it at present."""
        self._newcomers += tuple(spec for spec in scenario.robots if spec.id in self.strangers)
        self._told, self.strangers = (), frozenset()

    def announce(self, members: Iterable[Member]) -> None:
        """Take over what a roster says."""
        known = len(self.radii)
        self.radii.update((each.robot, each.radius) for each in members if each.status != "gone")
        if len(self.radii) > known:
            self._told = ()

    def __contains__(self, robot: int) -> bool:
        """Whether it is there."""
        return robot in self._places

    def see(self, truth: Truth) -> Changes:
        """Take over where everybody is; returns who came and who went."""
        self._truth = truth
        if truth.robots == self._told:
            return _NO_CHANGES
        self._told, before = truth.robots, self._places
        told = zip(truth.robots, truth.positions, strict=False)
        known = {spec.id for spec in self._newcomers} | self.radii.keys()
        self._places = {robot: place for robot, place in told if robot in known}
        self.strangers = frozenset(truth.robots) - known
        changes = Changes(self._places.keys() - before.keys(), before.keys() - self._places.keys())
        for robot in changes.went:  # its id may be given to another one
            self.goals.pop(robot, None)
            self.radii.pop(robot, None)
        for robot in changes.came:
            self._welcome(robot, self._places[robot])
        return changes

    def _welcome(self, robot: int, place: Vector) -> None:
        """One appeared; of several orders that add one of its id, by that which does so nearest to there."""
        specs = [spec for spec in self._newcomers if spec.id == robot]
        if specs:
            spec = min(specs, key=lambda each: math.dist(each.start, place))
            self.radii[robot], self.goals[robot] = spec.radius, spec.goal
