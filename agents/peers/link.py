"""Injected link faults: what happens to a peer's State between its arrival and its being heard.

States really travel robot to robot; delay, jitter, loss, duplication and partitions are added where
they are received. Each draw is keyed by (seed, receiver, tick of the State) with a column per
sender, so the order of arrival changes nothing.
"""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from agents.peers.state import PeerState
from protocol.draws import Purpose, generator
from protocol.scenario.model import Link as LinkFaults
from protocol.scenario.model import Partition, Scenario

_KEPT = 8  # ticks of draws that are remembered; any other can be drawn again


class Link:
    """States on their way to one robot.

    Attributes:
        ideal: whether there are no faults: every State is heard at its own tick.
        lost: States so far.
    """

    def __init__(self, scenario: Scenario, robot: int) -> None:
        self.lost = 0
        self._scenario = scenario
        self._faults = scenario.link
        self._robot = robot
        self.ideal = scenario.link == LinkFaults()
        drawn = () if self.ideal else scenario.ids
        self._column = {peer: column for column, peer in enumerate(drawn)}
        self._draws: dict[int, np.ndarray] = {}
        self._newest: dict[int, PeerState] = {}  # by sender
        self._early: list[PeerState] = []  # without faults: those that this robot's own tick is behind
        self._waiting: defaultdict[int, list[PeerState]] = defaultdict(list)  # by the tick when they are due

    def is_news(self, state: PeerState) -> bool:
        """Whether a State arrives for the first time: while the world waits for somebody it has all States
        said again, and how often is a matter of the wall clock, so that nothing may follow from it.

        The States of one life arrive in order, so that only its newest is said again. Between those of two
        lives there is no order: a frozen process may wake when its follower lives, and both repeat theirs.
        What an older life says after a newer one was heard is no news: nobody waits for it, and of two lives
        robots go by the newer, so that it may be lost. What is on its way is heard when it is due.
        """
        newest = self._newest.get(state.robot)
        if newest is not None and (
            state.incarnation < newest.incarnation
            or (state.incarnation == newest.incarnation and state.tick == newest.tick)
        ):
            return False
        self._newest[state.robot] = state
        return True

    def put(self, state: PeerState) -> None:
        """A peer's State has arrived; it will be heard at the tick that the faults leave it."""
        if self.ideal:
            self._early.append(state)
            return
        for tick in self._due(state):
            self._waiting[tick].append(state)

    def take(self, tick: int) -> list[PeerState]:
        """All States due up to and including `tick`, by due tick, then by sender and age; without faults
        as they came, which for each sender is by age too."""
        if self.ideal:
            return self._take_early(tick)
        taken: list[PeerState] = []
        for due in sorted([each for each in self._waiting if each <= tick]):
            taken += sorted(self._waiting.pop(due), key=_by_sender)
        return taken

    def _take_early(self, tick: int) -> list[PeerState]:
        early, self._early = self._early, []
        if not early:
            return early
        self._early = [state for state in early if state.tick > tick]
        return [state for state in early if state.tick <= tick] if self._early else early

    def _due(self, state: PeerState) -> list[int]:
        """Ticks at which copies of this State are heard; empty when it is lost."""
        faults = self._faults
        loss, duplicate, *spread = self._drawn_for(state.robot, state.tick)
        time = state.tick * self._scenario.time.step
        if loss < faults.loss or any(_parted(p, time, self._robot, state.robot) for p in faults.partition):
            self.lost += 1
            return []
        due = [self._delayed(state.tick, spread[0], spread[1])]
        if duplicate < faults.duplicate:
            due.append(self._delayed(state.tick, spread[2], spread[3]))
        return due

    def _delayed(self, tick: int, delay: float, jitter: float) -> int:
        bounds = self._faults.delay
        low, high = bounds if isinstance(bounds, tuple) else (bounds, bounds)
        return tick + self._scenario.ticks(low + delay * (high - low) + jitter * self._faults.jitter)

    def _drawn_for(self, peer: int, tick: int) -> list[float]:
        column = self._column.get(peer)
        if column is not None:
            drawn: list[float] = self._drawn(tick)[:, column].tolist()
            return drawn
        source = generator(self._scenario.seed, Purpose.LINK, self._robot, tick, peer)
        return list(source.random(6).tolist())

    def _drawn(self, tick: int) -> np.ndarray:
        drawn = self._draws.get(tick)
        if drawn is None:
            source = generator(self._scenario.seed, Purpose.LINK, self._robot, tick)
            drawn = self._draws[tick] = source.random((6, len(self._column)))
            if len(self._draws) > _KEPT:
                del self._draws[next(iter(self._draws))]
        return drawn


def _by_sender(state: PeerState) -> tuple[int, int]:
    return state.robot, state.tick


def _parted(partition: Partition, time: float, one: int, other: int) -> bool:
    """Whether this partition keeps two robots apart at `time`."""
    if not partition.from_ <= time < partition.until:
        return False
    return not any(one in group and other in group for group in partition.groups)
