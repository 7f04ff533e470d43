"""Large fleets: the peers whose States each robot receives, and the summary of all positions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

import numpy as np

from protocol.crowd import LEAD, period
from protocol.messages import Command, Sense, Summary, Vector
from protocol.scenario.model import Scenario


class Interest:
    """Interest management of a run in which robots receive the States of the peers in their bindings.

    Attributes:
        summary: the newest to publish; None before the first.
        places: last measured positions, m, by id.
    """

    def __init__(self, scenario: Scenario) -> None:
        self.summary: Summary | None = None
        self.places: dict[int, Vector] = {spec.id: spec.start for spec in scenario.robots}
        self._period = period(scenario)
        self._slices: dict[int, float] = {}  # m, of the newest Command
        # By robot: its life, and from which tick on it hears each peer.
        self._since: dict[int, tuple[int, dict[int, int]]] = {}

    def open(
        self,
        tick: int,
        scenario: Scenario,
        sensed: Mapping[int, Sense],
        goal: Callable[[int], Vector | None],
    ) -> None:
        """Begin a tick, with the measurement of every robot, and its goal (m) unless it is the scenario's."""
        for robot, sense in sensed.items():
            if sense.position is not None:
                self.places[robot] = sense.position
        if tick % self._period == 0:
            ids = scenario.ids
            starts = {spec.id: spec.start for spec in scenario.robots}
            places = np.array([self.places.get(robot, starts[robot]) for robot in ids], dtype=np.float64)
            goals = {spec.id: goal(spec.id) or spec.goal for spec in scenario.robots}
            away = places - np.array([goals[robot] for robot in ids], dtype=np.float64)
            gammas = (away**2).sum(axis=1)
            said = np.array([self._slices.get(robot, np.nan) for robot in ids])
            # Of a robot that has published no slice, that of the attraction alone.
            slices = np.where(np.isnan(said), 2.0 * np.sqrt(gammas), said)
            where, far, pace = (each.astype("<f4").tobytes() for each in (places, gammas, slices))
            self.summary = Summary(tick, runs(ids), where, far, pace)

    def accept(self, command: Command) -> None:
        """Note an accepted command."""
        if command.slice is not None:
            self._slices[command.robot] = command.slice

    def heard(
        self, robot: int, incarnation: int, tick: int, bound: Iterable[int], active: frozenset[int]
    ) -> tuple[int, ...]:
        """The active robots whose States a life receives in this tick, itself included, from the peers that
        it is `bound` to: it is subscribed to a peer LEAD ticks after the Tick that named it.
        """
        life, before = self._since.get(robot, (0, {}))
        if life != incarnation:
            before = {}
        since = {peer: before.get(peer, tick + LEAD) for peer in bound}
        self._since[robot] = incarnation, since
        heard = (peer for peer, begun in since.items() if begun <= tick and peer in active)
        return tuple(sorted([robot, *heard]))


def runs(ids: Iterable[int]) -> bytes:
    """Ascending ids as a Summary encodes them: the first of each run of consecutive ids, and its length."""
    found: list[list[int]] = []
    for each in ids:
        if found and each == sum(found[-1]):
            found[-1][1] += 1
        else:
            found.append([each, 1])
    return np.array(found, dtype="<u4").tobytes()
