"""The record of a run: all measures of the truth, tick by tick.

A run consists of segments with constant fleet, goals and obstacles; the measures of each are accumulated in
totals. Ticks are buffered and measured together: one pass of numpy over thirty ticks costs little more than
over one, and no robot waits for it.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Final, NamedTuple

import msgspec
import numpy as np
from msgspec.structs import replace

from protocol.arrays import Complexes, Reals
from protocol.geometry import Shape
from protocol.messages import LISTED, Count, Id, Truth, Vector
from protocol.scenario.model import Scenario
from world.judge.clearance import Disks, NearestGaps, gaps
from world.judge.measures import Goals, Level, levels_of

DiskPair = tuple[int, int]
Configurations = Sequence[Sequence[Vector]] | Reals  # shape (n, p, 2)

TOUCH: Final = 1e-9  # m; a gap below minus this is a contact, an exact touch with rounding is not
_SAME = 1e-6  # ticks; intervals with a smaller gap are joined
_RISE = 1e-12  # rounding of phi
_BATCH = 32  # most buffered ticks
_LARGEST = 1 << 14  # most gaps measured at once, limited by the processor's cache


class Segment(NamedTuple):
    """Fleet, goals and obstacles between two changes."""

    disks: Disks  # of the fleet, among the obstacles
    goals: Goals
    k: float
    gaps: NearestGaps  # of the disks


def segment_of(scenario: Scenario, goals: Goals, obstacles: Mapping[int, Shape] | None = None) -> Segment:
    """The segment of a fleet, among the scenario's obstacles or others."""
    disks = Disks.of(scenario, obstacles)
    return Segment(disks, goals, scenario.k, NearestGaps(disks))


class Contact(msgspec.Struct, array_like=True):
    """An overlap; times in ticks."""

    pair: DiskPair  # 0: the boundary, -n: obstacle n
    begin: float
    end: float
    deepest: float  # m, negative


class Totals(msgspec.Struct):
    """Measures of all segments so far."""

    truth: Truth  # the newest configuration
    clearance: float  # smallest gap, over continuous time, m
    first: Level  # of the first configuration
    deviation: dict[Id, float]  # largest distance of each present robot from its straight path, m
    increases: Count = 0  # ticks in which phi increased
    collisions: Count = 0  # overlaps
    contacts: list[Contact] = []  # the first `LISTED` of these, by their beginning
    touched: Count = 0  # contacts reported by the plant, each once
    touches: list[tuple[Count, DiskPair]] = []  # the first `LISTED` of these: tick and pair of ids
    touching: frozenset[DiskPair] = frozenset()  # pairs that were in such a contact in the last tick


class PastRecord(msgspec.Struct, frozen=True):
    """State for a successor: totals and goals at the last measurement, and later configurations."""

    totals: Totals
    goals: Goals
    aside: list[tuple[Vector, ...]]


class PastReferee(msgspec.Struct, frozen=True):
    """A referee's record of a run; a successor restarts the time without motion."""

    record: PastRecord
    worlds: tuple[Count, ...] = ()  # first ticks of the worlds that continued from others
    verdict: str = ""
    reason: str = ""


def trajectory_rows(ids: Sequence[int], ticks: Sequence[int], configurations: Configurations) -> bytes:
    """What a trajectory's SHA-256 is over: tick by tick and in the order of ids, the four little-endian
    doubles tick, robot id, x, y (m)."""
    rows = np.empty((len(ticks), len(ids), 4), dtype="<f8")
    rows[..., 0] = np.asarray(ticks)[:, None]
    rows[..., 1] = ids
    rows[..., 2:] = configurations
    return rows.tobytes()


class Record:
    """Accumulates segments in totals.

    Args:
        scenario: with the present robots.
        positions: of all disks in the order of robot ids, m.
        parts: straight motions per tick.
        past: of an earlier record; the digest begins with its newest configuration.
        obstacles: shapes by number; by default those of the scenario.
    """

    def __init__(
        self,
        scenario: Scenario,
        positions: Sequence[Vector],
        parts: int = 1,
        past: PastRecord | None = None,
        obstacles: Mapping[int, Shape] | None = None,
    ) -> None:
        goals = Goals.of(scenario) if past is None else past.goals
        self.segment = segment_of(scenario, goals, obstacles)
        self._parts = parts
        self._batch = parts * max(1, min(_BATCH, _LARGEST // parts // len(self.segment.disks)))
        self._news: list[Truth] = []
        self._digest = hashlib.sha256()
        if past is None:
            first = levels_of(*self.segment[:3], as_plane([positions]))[0]
            truth = Truth(0, scenario.ids, tuple(positions), math.inf, *first)
            self._totals = Totals(truth, math.inf, first, dict.fromkeys(scenario.ids, 0.0))
        else:
            self._totals = past.totals
        self._latest = {contact.pair: contact for contact in self._totals.contacts}
        self._plane, self._begun = as_plane([self._totals.truth.positions]), False
        self._aside = [] if past is None else [*past.aside]
        truth = self.totals.truth
        self._news = self._news or [truth]
        self._digest = hashlib.sha256(trajectory_rows(scenario.ids, [truth.tick], [truth.positions]))

    @property
    def past(self) -> PastRecord:
        """The state for a successor."""
        return PastRecord(self._totals, self.segment.goals, self._aside)

    def add(
        self,
        positions: Sequence[Vector],
        between: Sequence[tuple[Vector, ...]] = (),
        touching: Iterable[DiskPair] = (),
    ) -> None:
        """Add the configuration after a tick of straight motions through those `between`. The plant itself
        has detected contacts of the pairs `touching`.
        """
        self._aside.extend(between)
        self._aside.append(tuple(positions))
        present, totals = frozenset(touching), self._totals
        for pair in sorted(present - totals.touching):
            totals.touched += 1
            if len(totals.touches) < LISTED:
                tick = totals.truth.tick + len(self._aside) // self._parts - 1
                totals.touches.append((tick, pair))
        totals.touching = present
        if len(self._aside) >= self._batch:
            self._measure()

    def set_fleet(
        self, scenario: Scenario, positions: Sequence[Vector], obstacles: Mapping[int, Shape]
    ) -> None:
        """Continue with the robots of another scenario, now at `positions`, among obstacles by number."""
        self._continue(segment_of(scenario, self.segment.goals.of_fleet(scenario), obstacles))
        totals = self._totals
        totals.deviation = {robot: totals.deviation.get(robot, 0.0) for robot in scenario.ids}
        totals.truth = replace(totals.truth, robots=scenario.ids, positions=tuple(positions))
        self._plane = as_plane([positions])

    def set_goal(self, robot: int, goal: Vector) -> None:
        """Continue with another `goal` of a robot, m."""
        self._measure()
        truth = self._totals.truth
        goals = self.segment.goals.to(robot, goal, truth.positions[truth.robots.index(robot)])
        self._continue(self.segment._replace(goals=goals))

    def set_obstacles(self, obstacles: Mapping[int, Shape]) -> None:
        """Continue with these obstacles, by number."""
        disks = self.segment.disks.among(obstacles)
        self._continue(self.segment._replace(disks=disks, gaps=NearestGaps(disks)))

    def _continue(self, segment: Segment) -> None:
        """Continue with another segment, which begins once all its changes are known."""
        self._measure()
        self.segment, self._begun = segment, False

    def begin(self) -> None:
        """Measure the first configuration of a segment, in which disks may overlap already."""
        if self._begun:
            return
        self._begun, totals, truth = True, self._totals, self._totals.truth
        disks, (nearest,) = self.segment.gaps(self._plane, self._plane)
        for index in (nearest < -TOUCH).nonzero()[0].tolist():
            self._touch(disks.names(index), truth.tick, truth.tick, float(nearest[index]))
        least, level = float(nearest.min()), levels_of(*self.segment[:3], self._plane)[0]
        totals.truth = replace(truth, clearance=min(truth.clearance, least), **level._asdict())
        totals.clearance = min(totals.clearance, least)

    @property
    def totals(self) -> Totals:
        """Totals up to the newest configuration."""
        self._measure()
        self.begin()
        return self._totals

    def sha256(self) -> str:
        """Digest of the trajectory so far."""
        self._measure()
        return self._digest.hexdigest()

    def news(self) -> list[Truth]:
        """The configurations since the last call, in order."""
        self._measure()
        news, self._news = self._news, []
        return news

    def _measure(self) -> None:
        aside, self._aside = self._aside, []
        if not aside:
            return
        self.begin()
        plane, parts, totals = as_plane(aside), self._parts, self._totals
        before = np.concatenate((self._plane, plane[:-1]))
        disks, during = self.segment.gaps(before, plane)
        for row, nearest in enumerate(during):
            tick = totals.truth.tick + row / parts
            for index in (nearest < -TOUCH).nonzero()[0].tolist() if nearest.min() < -TOUCH else ():
                start, motion = before[row], plane[row] - before[row]
                found = disks.overlaps(index, start, plane[row], TOUCH)
                for begin, end in found:
                    ends = start + begin * motion, start + end * motion
                    deepest = nearest[index] if len(found) == 1 else gaps(disks, *ends)[index]
                    times = tick + begin / parts, tick + end / parts
                    self._touch(disks.names(index), *times, float(deepest))
        worst = self.segment.goals.deviations(plane).max(axis=0).tolist()
        for robot, deviation in zip(disks.ids, worst, strict=True):
            totals.deviation[robot] = max(totals.deviation[robot], deviation)
        self._publish_truth(
            aside[parts - 1 :: parts], during.min(axis=1).reshape(-1, parts).min(axis=1).tolist()
        )
        self._plane = plane[-1:]

    def _touch(self, pair: DiskPair, begin: float, end: float, gap: float) -> None:
        latest, totals = self._latest.get(pair), self._totals
        if latest is not None and begin <= latest.end + _SAME:
            latest.end, latest.deepest = end, min(latest.deepest, gap)
            return
        self._latest[pair] = contact = Contact(pair, begin, end, gap)
        totals.collisions += 1
        if len(totals.contacts) < LISTED:
            totals.contacts.append(contact)

    def _publish_truth(self, configurations: list[tuple[Vector, ...]], smallest: list[float]) -> None:
        """Add the configurations at the ends of ticks, with the smallest gap in each of these."""
        totals, begin = self._totals, self._totals.truth.tick + 1
        levels = levels_of(*self.segment[:3], as_plane(configurations))
        for row, (positions, clearance, level) in enumerate(
            zip(configurations, smallest, levels, strict=True)
        ):
            totals.increases += level.phi > totals.truth.phi + _RISE
            totals.truth = Truth(begin + row, totals.truth.robots, positions, clearance, *level)
            self._news.append(totals.truth)
        ticks = range(begin, begin + len(configurations))
        self._digest.update(trajectory_rows(totals.truth.robots, ticks, configurations))
        totals.clearance = min(totals.clearance, *smallest)


def as_plane(positions: Sequence[Sequence[Vector]]) -> Complexes:
    """Configurations as complex numbers x + iy, shape (n, p)."""
    plane: Complexes = np.array(positions).view(np.complex128)[..., 0]
    return plane
