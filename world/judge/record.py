"""The record of a run: everything that is measured of the truth, tick by tick.

A run consists of segments, in which fleet, goals and obstacles stay the same; what is measured of each is
folded into totals. Ticks are put aside and measured some at a time: one pass of numpy over thirty ticks costs
little more than over one, and no robot waits for it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import msgspec
import numpy as np

from protocol.geometry import Shape
from protocol.messages import Count, Id, Truth, Vector
from protocol.scenario.model import Scenario
from world.judge.clearance import Disks, NearestGaps, Plane, gaps
from world.judge.contacts import Contact, Contacts
from world.judge.measures import Goals, Level, levels_of
from world.judge.trajectory import TrajectoryDigest

_RISE = 1e-12  # an increase of phi below this is rounding
_BATCH = 32  # ticks put aside at most
_LARGEST = 1 << 14  # gaps measured at once at most: more would not stay in the processor's cache


class Segment(NamedTuple):
    """What stays the same between two changes."""

    disks: Disks  # of the fleet, among the obstacles
    goals: Goals
    k: float
    gaps: NearestGaps  # of the disks

    def truth(self, tick: int, positions: Sequence[Vector]) -> Truth:
        """What is measured of one configuration by itself."""
        plane = as_plane([positions])
        clearance, level = float(gaps(self.disks, plane, plane).min()), levels_of(*self[:3], plane)[0]
        return Truth(tick, self.disks.ids, tuple(positions), clearance, *level)


def segment_of(scenario: Scenario, goals: Goals, obstacles: Mapping[int, Shape] | None = None) -> Segment:
    """The segment of a fleet, among the scenario's obstacles unless there are others."""
    disks = Disks.of(scenario, obstacles)
    return Segment(disks, goals, scenario.k, NearestGaps(disks))


@dataclass
class Totals:
    """What all segments so far amount to.

    Attributes:
        truth: the newest configuration.
        clearance: smallest gap, over continuous time, m.
        first: phi and its logarithm in the first configuration.
        increases: number of ticks in which phi rose.
        deviation: largest distance from its straight way of each robot that is there, m.
        contacts: overlaps.
    """

    truth: Truth
    clearance: float
    first: Level
    deviation: dict[int, float]
    increases: int = 0
    contacts: Contacts = field(default_factory=Contacts)


class Measured(msgspec.Struct, frozen=True):
    """What a record has come to.

    Attributes:
        truth, clearance, first, increases, deviation, contacts: as in `Totals`.
        ways: where the straight way of each robot begins and ends, m, in the order of ids.
        behind: length of straight ways that are over, m.
    """

    truth: Truth
    clearance: float
    first: Level
    increases: Count
    deviation: dict[Id, float]
    contacts: list[Contact]
    ways: list[tuple[Vector, Vector]]
    behind: float


class PastRecord(msgspec.Struct, frozen=True):
    """What another record needs to go on from one; asked for in each tick, and encoded as it comes to be.

    Attributes:
        measured: `Measured`, with the last batch.
        aside: list of the configurations since then.
    """

    measured: msgspec.Raw
    aside: msgspec.Raw


_encode = msgspec.msgpack.encode
_measured = msgspec.msgpack.Decoder(Measured).decode
_configurations = msgspec.msgpack.Decoder(list[tuple[Vector, ...]]).decode


class Record:
    """Folds segments into totals.

    Args:
        scenario: with the robots that are there.
        positions: of all disks in the order of robot ids, m.
        parts: straight motions that a tick consists of.
        past: to go on from; the digest is of the configurations from the newest of these on.
        obstacles: shapes by number; those of the scenario unless given.

    Attributes:
        segment: the present one.
    """

    def __init__(
        self,
        scenario: Scenario,
        positions: Sequence[Vector],
        parts: int = 1,
        past: PastRecord | None = None,
        obstacles: Mapping[int, Shape] | None = None,
    ) -> None:
        before = None if past is None else _measured(past.measured)
        goals = Goals.of(scenario)
        if before is not None:
            goals = Goals.between(scenario.ids, before.ways, before.behind)
        self.segment = segment_of(scenario, goals, obstacles)
        self._parts = parts
        self._batch = parts * max(1, min(_BATCH, _LARGEST // parts // len(self.segment.disks)))
        self._aside: list[tuple[Vector, ...]] = []
        self._measured: msgspec.Raw | None = None  # as in `PastRecord`
        self._written, self._encoded = 0, bytearray()  # of those put aside
        self._news: list[Truth] = []
        self._digest = TrajectoryDigest(scenario.ids)
        if past is None or before is None:
            truth = self.segment.truth(0, positions)
            level, deviation = Level(truth.phi, truth.log_potential), dict.fromkeys(scenario.ids, 0.0)
            self._totals = Totals(truth, truth.clearance, level, deviation)
        else:
            contacts = Contacts(before.contacts)
            self._totals = Totals(
                before.truth, before.clearance, before.first, before.deviation, before.increases, contacts
            )
            self._aside.extend(_configurations(past.aside))
        self._plane = as_plane([self._totals.truth.positions])
        self._measure()
        truth = self._totals.truth
        self._news = self._news or [truth]
        self._digest = TrajectoryDigest(scenario.ids)
        self._digest.add([truth.tick], [truth.positions])

    @property
    def past(self) -> PastRecord:
        """What another record needs to go on from here."""
        if self._measured is None:
            totals, goals = self._totals, self.segment.goals
            measured = Measured(
                totals.truth,
                totals.clearance,
                totals.first,
                totals.increases,
                totals.deviation,
                totals.contacts.all,
                goals.ways,
                goals.behind,
            )
            self._measured, self._written, self._encoded = msgspec.Raw(_encode(measured)), 0, bytearray()
        for each in self._aside[self._written :]:
            self._encoded += _encode(each)
        self._written = len(self._aside)
        array = b"\xdc" + self._written.to_bytes(2, "big")  # msgpack's: so many follow
        return PastRecord(self._measured, msgspec.Raw(array + self._encoded))

    def add(self, positions: Sequence[Vector], between: Sequence[tuple[Vector, ...]] = ()) -> None:
        """The configuration one tick later, reached by straight motion since the one before; if a tick has
        several parts, through those `between`."""
        self._aside.extend(between)
        self._aside.append(tuple(positions))
        if len(self._aside) >= self._batch:
            self._measure()

    def set_fleet(
        self, scenario: Scenario, positions: Sequence[Vector], obstacles: Mapping[int, Shape]
    ) -> None:
        """From the newest configuration on, which is `positions` now, the robots of another scenario are
        judged, among obstacles of these shapes, by number."""
        totals, self._measured = self.totals, None
        self.segment = segment_of(scenario, self.segment.goals.of_fleet(scenario), obstacles)
        totals.contacts.end()
        totals.deviation = {robot: totals.deviation.get(robot, 0.0) for robot in scenario.ids}
        totals.truth = self.segment.truth(totals.truth.tick, positions)
        totals.clearance = min(totals.clearance, totals.truth.clearance)
        self._digest.set_fleet(scenario.ids)  # from the next tick on
        self._plane = as_plane([positions])

    def set_goal(self, robot: int, goal: Vector) -> None:
        """From the newest configuration on a robot is to go to `goal`, m."""
        truth, self._measured = self.totals.truth, None
        goals = self.segment.goals.to(robot, goal, truth.positions[truth.robots.index(robot)])
        self.segment = self.segment._replace(goals=goals)

    def set_obstacles(self, obstacles: Mapping[int, Shape]) -> None:
        """From the newest configuration on there are these obstacles, by number."""
        self._measure()
        disks = self.segment.disks.among(obstacles)
        self.segment = self.segment._replace(disks=disks, gaps=NearestGaps(disks))

    @property
    def totals(self) -> Totals:
        """Up to the newest configuration."""
        self._measure()
        return self._totals

    def sha256(self) -> str:
        """Digest of the trajectory so far."""
        self._measure()
        return self._digest.hexdigest()

    def news(self) -> list[Truth]:
        """Every configuration, in order, that was not handed out yet; for once."""
        self._measure()
        news, self._news = self._news, []
        return news

    def _measure(self) -> None:
        """Measure what was put aside."""
        aside, self._aside = self._aside, []
        if not aside:
            return
        self._measured = None
        plane, parts, totals = as_plane(aside), self._parts, self._totals
        before = np.concatenate((self._plane, plane[:-1]))
        disks, during = self.segment.gaps(before, plane)
        for row, nearest in enumerate(during):
            tick = totals.truth.tick + row / parts
            totals.contacts.add(tick, disks, nearest, before[row], plane[row], 1.0 / parts)
        away = self.segment.goals.deviations(plane).max(axis=0).tolist()
        for robot, deviation in zip(disks.ids, away, strict=True):
            totals.deviation[robot] = max(totals.deviation[robot], deviation)
        self._tell(aside[parts - 1 :: parts], during.min(axis=1).reshape(-1, parts).min(axis=1).tolist())
        self._plane = plane[-1:]

    def _tell(self, configurations: list[tuple[Vector, ...]], smallest: list[float]) -> None:
        """Take in the configurations at the ends of ticks, with the smallest gap in each of these."""
        totals, begin = self._totals, self._totals.truth.tick + 1
        levels = levels_of(*self.segment[:3], as_plane(configurations))
        for row, (positions, clearance, level) in enumerate(
            zip(configurations, smallest, levels, strict=True)
        ):
            totals.increases += level.phi > totals.truth.phi + _RISE
            totals.truth = Truth(begin + row, totals.truth.robots, positions, clearance, *level)
            self._news.append(totals.truth)
        self._digest.add(range(begin, begin + len(configurations)), configurations)
        totals.clearance = min(totals.clearance, *smallest)


def as_plane(positions: Sequence[Sequence[Vector]]) -> Plane:
    """Configurations as complex numbers x + iy, shape (n, p)."""
    plane: Plane = np.array(positions).view(np.complex128)[..., 0]
    return plane
