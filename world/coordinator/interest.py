"""Who is near whom, and what everybody is told of the others.

Both follow from what robots were told of their own places, so from scenario and inputs alone. Two robots come
to be near when the gap between their disks is less than `protocol.interest.inner`, and cease to be when it is
more than `outer`: always both.
"""

from __future__ import annotations

from collections.abc import Container, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from protocol.interest import LEAD, inner, outer, period
from protocol.messages import Sense, Summary, Vector
from protocol.scenario.model import Scenario


@dataclass(slots=True)
class _Told:
    """Whom one incarnation hears, as it was told."""

    incarnation: int
    near: frozenset[int] = frozenset()
    coming: frozenset[int] = frozenset()
    since: int = 0  # tick from which those are heard


class Interest:
    """Of a run in which robots hear near ones only.

    Attributes:
        summary: newest that is to be told; None before the first.
    """

    def __init__(self, scenario: Scenario) -> None:
        self.summary: Summary | None = None
        self._period = period(scenario)
        self._inner, self._outer = inner(scenario), outer(scenario)
        self._places: dict[int, Vector] = {spec.id: spec.start for spec in scenario.robots}
        self._ids: tuple[int, ...] = ()
        self._radii: NDArray[np.float64] = np.zeros(0)
        self._near: NDArray[np.bool_] = np.zeros((0, 0), dtype=np.bool_)
        self._sets: dict[int, frozenset[int]] = {}
        self._told: dict[int, _Told] = {}

    def open(
        self, tick: int, scenario: Scenario, sensed: Mapping[int, Sense], goals: Mapping[int, Vector]
    ) -> None:
        """A tick begins, with what every robot is told of its own place, and its goal, m."""
        self._places |= {
            robot: sense.position for robot, sense in sensed.items() if sense.position is not None
        }
        if tick % self._period and self._ids == scenario.ids:
            return
        if self._ids != scenario.ids:
            self._recast(scenario)
        places = np.array([self._places[robot] for robot in self._ids], dtype=np.float64)
        self._survey(places, self._radii)
        if tick % self._period == 0:
            away = places - np.array([goals[robot] for robot in self._ids], dtype=np.float64)
            ids, gammas = np.array(self._ids, dtype="<u4"), (away**2).sum(axis=1)
            packed = (ids.tobytes(), places.astype("<f8").tobytes(), gammas.astype("<f8").tobytes())
            self.summary = Summary(tick, *packed)

    def _recast(self, scenario: Scenario) -> None:
        """Robots came or went; who was near remains so."""
        before, known = self._ids, self._near
        self._ids = scenario.ids
        radii = {spec.id: spec.radius for spec in scenario.robots}
        self._radii = np.array([radii[robot] for robot in self._ids], dtype=np.float64)
        self._places = {spec.id: self._places.get(spec.id, spec.start) for spec in scenario.robots}
        self._near = np.zeros((len(self._ids), len(self._ids)), dtype=np.bool_)
        stay = [robot for robot in self._ids if robot in before]
        old, new = [before.index(robot) for robot in stay], [self._ids.index(robot) for robot in stay]
        self._near[np.ix_(new, new)] = known[np.ix_(old, old)]

    def _survey(self, places: NDArray[np.float64], radii: NDArray[np.float64]) -> None:
        """Who is near whom from these places (m), and from who was."""
        between = places[:, None, :] - places[None, :, :]
        gap = np.sqrt((between**2).sum(axis=2)) - radii[:, None] - radii[None, :]
        self._near = (gap < self._inner) | (self._near & (gap <= self._outer))
        np.fill_diagonal(self._near, val=False)
        ids = np.array(self._ids)
        self._sets = {
            robot: frozenset(ids[row].tolist()) for robot, row in zip(self._ids, self._near, strict=True)
        }

    def tell(self, robot: int, incarnation: int, tick: int) -> tuple[int, ...] | None:
        """Whom to announce as near to a robot in this tick; None if nobody is to be announced."""
        told = self._told.get(robot)
        if told is None or told.incarnation != incarnation:
            told = self._told[robot] = _Told(incarnation)
        elif tick % self._period:
            return None
        elif tick >= told.since:
            told.near = told.coming
        told.coming, told.since = self._sets.get(robot, frozenset()), tick + LEAD
        return tuple(sorted(told.coming))

    def heard(self, robot: int, incarnation: int, tick: int, active: Container[int]) -> tuple[int, ...]:
        """Which of the active robots this one hears in this tick, itself included; an incarnation that was
        told of nobody hears nobody."""
        told = self._told.get(robot)
        if told is not None and told.coming is not told.near and tick >= told.since:
            told.near = told.coming
        near = frozenset() if told is None or told.incarnation != incarnation else told.near
        return tuple(each for each in sorted(near | {robot}) if each in active)
