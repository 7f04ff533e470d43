"""Injected link faults: delay and loss of a peer's State between its arrival and the tick of its delivery.

States travel robot to robot; the faults are added at the receiver. Each draw is keyed by (seed, receiver,
tick of the State) with a column per sender, and those of radios by robot and tick: the order of arrival
changes nothing, sender and receivers agree, and a later life of a robot draws the same faults as an earlier
one.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import defaultdict
from collections.abc import Iterable
from math import dist
from typing import Final

import numpy as np

from agents.peers.state import PeerState
from protocol.draws import Purpose, Uniforms, generator
from protocol.messages import Vector
from protocol.scenario.body import span_of
from protocol.scenario.model import Scenario
from protocol.scenario.network import Burst, Partition, Roaming
from protocol.scenario.network import Link as LinkFaults

_BLOCKS: Final = 4  # of draws, kept for late States


class Radio:
    """Channel and access point of one robot's radio at each tick."""

    def __init__(self, scenario: Scenario, robot: int) -> None:
        self._scenario = scenario
        self._draws = Uniforms(scenario.seed, Purpose.RADIO, robot, 4, _BLOCKS)
        step, burst, roaming = scenario.time.step, scenario.link.burst or Burst(), scenario.link.roaming
        self._worse, self._better = min(0.5, step / burst.good), min(0.5, step / burst.bad)
        self._roaming = roaming or Roaming()
        self._window = max(1, scenario.ticks(self._roaming.every))
        self._is_bad, self._tick = False, -1

    def is_bad(self, tick: int) -> bool:
        """Whether its channel is bad, by the chain of Gilbert and Elliott: a draw below `worse` makes it bad,
        one above 1 - `better` good, and the last such draw decides."""
        for earlier in range(tick, -1, -1):
            if earlier == self._tick:
                break
            draw = self._draws.at(earlier)[0]
            if draw < self._worse or draw >= 1.0 - self._better:
                self._is_bad = draw < self._worse
                break
        else:
            self._is_bad = False
        self._tick = tick
        return self._is_bad

    def back(self, tick: int) -> int:
        """The first tick at or after `tick` at which it has an access point."""
        window = tick // self._window
        for each in (window - 1, window):  # a gap ends before the next window does
            begin, end = self._gap(each) if each >= 0 else (0, 0)
            if begin <= tick < end:
                return self.back(end)
        return tick

    def slot(self, tick: int) -> float:
        """Order of transmission within a tick: a robot with a smaller number sends earlier."""
        return self._draws.at(tick)[1]

    def _gap(self, window: int) -> tuple[int, int]:
        low, high = span_of(self._roaming.gap)
        _, _, place, length = self._draws.at(window * self._window)
        begin = window * self._window + int(place * self._window)
        return begin, begin + self._scenario.ticks(low + length * (high - low))


_KEPT = 8  # ticks of draws and positions kept; others are drawn again
_DRAWS = 6  # per State; twice as many in a wireless network


class StateLink:
    """Delivery of States to one robot."""

    def __init__(self, scenario: Scenario, robot: int) -> None:
        self.lost = 0  # States lost so far
        self._scenario = scenario
        self._faults = scenario.link
        self._robot = robot
        self.ideal = scenario.link == LinkFaults()  # no faults: every State is delivered in its own tick
        drawn = () if self.ideal else scenario.ids
        self._column = {peer: column for column, peer in enumerate(drawn)}
        self._draws: dict[int, np.ndarray] = {}
        self._early: list[PeerState] = []  # of ticks that have not begun
        self._radios: dict[int, Radio] = {}  # by robot
        self._slots: tuple[int, list[float]] = (-1, [])  # of the newest tick, sorted
        self._places: dict[int, Vector] = {}  # positions of this robot, m, by tick
        faults = scenario.link
        self._is_wireless = any(each is not None for each in (faults.capacity, faults.burst, faults.distance))
        self._rows = _DRAWS * (1 + self._is_wireless)
        self._waiting: defaultdict[int, list[PeerState]] = defaultdict(list)  # by the tick when they are due

    def locate(self, tick: int, place: Vector | None) -> None:
        """Set this robot's position, m, as `tick` opens; None if it is unknown."""
        if place is not None and self._faults.distance is not None:
            self._places[tick] = place
            if len(self._places) > _KEPT:
                del self._places[next(iter(self._places))]

    def put(self, state: PeerState) -> None:
        """Receive a peer's State. A repeated one meets the same draws: it is lost if the first was, and
        delivered no earlier."""
        self._early.append(state)

    def ahead(self, tick: int) -> Iterable[int]:
        """Robots whose States of `tick`, or of a later one, have arrived."""
        return [state.robot for state in self._early if state.tick >= tick]

    def take(self, tick: int) -> list[PeerState]:
        """States due up to `tick`, by due tick, then sender and age; without faults in order of arrival."""
        early = [state for state in self._early if state.tick <= tick]
        self._early = [state for state in self._early if state.tick > tick]
        if self.ideal:
            return early
        for state in early:
            for due in self._due(state):
                self._waiting[due].append(state)
        taken: list[PeerState] = []
        for due in sorted([each for each in self._waiting if each <= tick]):
            taken += sorted(self._waiting.pop(due), key=lambda each: (each.robot, each.tick))
        return taken

    def _due(self, state: PeerState) -> list[int]:
        """Ticks at which copies of this State are delivered; empty when it is lost."""
        faults = self._faults
        loss, duplicate, *spread = self._drawn_for(state.robot, state.tick)
        time = state.tick * self._scenario.time.step
        late = self._wireless(state, spread[4:]) if self._is_wireless else 0.0
        if (
            late is None
            or loss < faults.loss
            or any(_parted(p, time, self._robot, state.robot) for p in faults.partition)
        ):
            self.lost += 1
            return []
        due = [self._delayed(state, late, spread[0], spread[1])]
        if duplicate < faults.duplicate:
            due.append(self._delayed(state, late, spread[2], spread[3]))
        return due

    def _delayed(self, state: PeerState, late: float, delay: float, jitter: float) -> int:
        low, high = span_of(self._faults.delay)
        sent = self._radio(state.robot).back(state.tick) if self._faults.roaming else state.tick
        due = sent + self._scenario.ticks(late + low + delay * (high - low) + jitter * self._faults.jitter)
        return self._radio(self._robot).back(due) if self._faults.roaming else due

    def _wireless(self, state: PeerState, draws: list[float]) -> float | None:
        """Delay, s, by distance, medium, and the radios of sender and receiver; None if the State is lost."""
        faults, late = self._faults, 0.0
        if (
            faults.distance is not None
            and (place := self._places.get(state.tick)) is not None
            and state.placed
        ):
            beyond = max(0.0, dist(place, (state.x, state.y)) - faults.distance.free)
            late += beyond * faults.distance.delay
            if draws[0] < beyond * faults.distance.loss:
                return None
        if faults.capacity is not None:
            wait = self._carried(state) / faults.capacity
            if wait > self._scenario.time.step:  # the sender's next State replaces it
                return None
            late += wait
        if faults.burst is not None:
            low, high = span_of(faults.burst.delay)
            for robot, loss, delay in ((state.robot, draws[1], draws[2]), (self._robot, draws[3], draws[4])):
                if self._radio(robot).is_bad(state.tick):
                    late += low + delay * (high - low)
                    if loss < faults.burst.loss:
                        return None
        return late

    def _carried(self, state: PeerState) -> int:
        """Number of States of its tick that the medium has carried with this one."""
        if state.tick != self._slots[0]:
            slots = sorted(self._radio(robot).slot(state.tick) for robot in self._scenario.ids)
            self._slots = state.tick, slots
        return 1 + bisect_left(self._slots[1], self._radio(state.robot).slot(state.tick))

    def _radio(self, robot: int) -> Radio:
        radio = self._radios.get(robot)
        if radio is None:
            radio = self._radios[robot] = Radio(self._scenario, robot)
        return radio

    def _drawn_for(self, peer: int, tick: int) -> list[float]:
        column = self._column.get(peer)
        if column is not None:
            drawn: list[float] = self._drawn(tick)[:, column].tolist()
            return drawn
        source = generator(self._scenario.seed, Purpose.LINK, self._robot, tick, peer)
        return list(source.random(self._rows).tolist())

    def _drawn(self, tick: int) -> np.ndarray:
        drawn = self._draws.get(tick)
        if drawn is None:
            source = generator(self._scenario.seed, Purpose.LINK, self._robot, tick)
            drawn = self._draws[tick] = source.random((self._rows, len(self._column)))
            if len(self._draws) > _KEPT:
                del self._draws[next(iter(self._draws))]
        return drawn


def _parted(partition: Partition, time: float, one: int, other: int) -> bool:
    if not partition.from_ <= time < partition.until:
        return False
    return not any(one in group and other in group for group in partition.groups)
