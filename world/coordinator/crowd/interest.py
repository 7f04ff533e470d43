"""Who is near whom, and what everybody is told of the others.

Both follow from what robots were told of their own places, so from scenario and inputs alone. Two robots come
to be near when the gap between their disks is less than `protocol.crowd.interest.inner`, and cease to be when
it is more than `outer`: always both.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from protocol.crowd.interest import LEAD, inner, outer, period
from protocol.messages import Command, Sense, Summary, Vector
from protocol.scenario.model import Scenario
from world.close_pairs import close_pairs


@dataclass(slots=True)
class _Told:
    """Whom one incarnation hears, as it was told; ids ascending."""

    incarnation: int
    near: tuple[int, ...]  # itself included
    coming: tuple[int, ...] = ()
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
        self._slices: dict[int, float] = {}  # m, as last commanded
        self._ids: tuple[int, ...] = ()
        self._radii: NDArray[np.float64] = np.zeros(0)
        self._pairs: frozenset[tuple[int, int]] = frozenset()  # who are near, the lower id first
        self._near: dict[int, tuple[int, ...]] = {}  # of each robot, ascending
        self._told: dict[int, _Told] = {}

    def open(
        self,
        tick: int,
        scenario: Scenario,
        sensed: Mapping[int, Sense],
        goal: Callable[[int], Vector | None],
    ) -> None:
        """A tick begins, with what every robot is told of its own place, and where it is sent, m, unless to
        the scenario's goal."""
        self._places |= {
            robot: sense.position for robot, sense in sensed.items() if sense.position is not None
        }
        if tick % self._period and self._ids == scenario.ids:
            return
        if self._ids != scenario.ids:
            self._recast(scenario)
        places = np.array([self._places[robot] for robot in self._ids], dtype=np.float64)
        self._survey(places.view(np.complex128)[:, 0])
        if tick % self._period == 0:
            goals = {spec.id: goal(spec.id) or spec.goal for spec in scenario.robots}
            away = places - np.array([goals[robot] for robot in self._ids], dtype=np.float64)
            gammas = (away**2).sum(axis=1)
            slices = self._norms(2.0 * np.sqrt(gammas))
            where, far, pace = (each.astype("<f4").tobytes() for each in (places, gammas, slices))
            self.summary = Summary(tick, runs(self._ids), where, far, pace)

    def accept(self, command: Command) -> None:
        """A command was taken."""
        if command.slice is not None:
            self._slices[command.robot] = command.slice

    def _norms(self, attraction: NDArray[np.float64]) -> NDArray[np.float64]:
        """Of the slices of all; of who has said none, what the attraction alone (m) gives."""
        said = np.array([self._slices.get(robot, np.nan) for robot in self._ids])
        return np.where(np.isnan(said), attraction, said)

    def _recast(self, scenario: Scenario) -> None:
        """Robots came or went; who was near remains so."""
        self._ids = scenario.ids
        radii = {spec.id: spec.radius for spec in scenario.robots}
        self._radii = np.array([radii[robot] for robot in self._ids], dtype=np.float64)
        self._places = {spec.id: self._places.get(spec.id, spec.start) for spec in scenario.robots}

    def _survey(self, places: NDArray[np.complex128]) -> None:
        """Who is near whom from these places (m), and from who was."""
        ids = np.array(self._ids)
        first, second = close_pairs(places, self._radii, self._outer)
        gaps = np.abs(places[first] - places[second]) - (self._radii[first] + self._radii[second])
        pairs = zip(ids[first].tolist(), ids[second].tolist(), strict=True)
        inside = (gaps < self._inner).tolist()
        found = [pair for pair, is_in in zip(pairs, inside, strict=True) if is_in or pair in self._pairs]
        near: dict[int, list[int]] = {robot: [] for robot in self._ids}
        for one, other in found:
            near[one].append(other)
            near[other].append(one)
        self._pairs = frozenset(found)
        self._near = {robot: tuple(sorted(peers)) for robot, peers in near.items()}

    def tell(self, robot: int, incarnation: int, tick: int) -> tuple[int, ...] | None:
        """Whom to announce as near to a robot in this tick; None if nobody is to be announced."""
        told = self._told.get(robot)
        if told is None or told.incarnation != incarnation:
            told = self._told[robot] = _Told(incarnation, (robot,))
        elif tick % self._period:
            return None
        elif tick >= told.since:
            told.near = told.coming
        announced = self._near.get(robot, ())
        told.coming, told.since = tuple(sorted((robot, *announced))), tick + LEAD
        return announced

    def heard(
        self, robot: int, incarnation: int, tick: int, active: frozenset[int]
    ) -> tuple[int, ...] | None:
        """Which of the active robots this one hears in this tick, itself included; None if those are all whom
        it was told that it hears, `near`. An incarnation that was told of nobody hears nobody."""
        told = self._told.get(robot)
        if told is not None and told.coming and tick >= told.since:
            told.near = told.coming
        if told is None or told.incarnation != incarnation:
            return (robot,)
        return None if active.issuperset(told.near) else tuple(each for each in told.near if each in active)

    def near(self, robot: int) -> tuple[int, ...]:
        """Whom a robot that is told anything hears in this tick if all take part, itself included."""
        return self._told[robot].near


def runs(ids: Iterable[int]) -> bytes:
    """Ascending ids as a Summary has them: of each run of consecutive ones the first, and how many."""
    found: list[list[int]] = []
    for each in ids:
        if found and each == sum(found[-1]):
            found[-1][1] += 1
        else:
            found.append([each, 1])
    return np.array(found, dtype="<u4").tobytes()
