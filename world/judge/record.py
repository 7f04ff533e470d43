"""The record of a run: everything that is measured of the truth, tick by tick.

What happened is put aside and measured some ticks at a time: one pass of numpy over thirty ticks
costs little more than over one, and nobody has to wait for it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from mypy_extensions import mypyc_attr

from protocol.geometry import Shape
from protocol.messages import Truth, Vector
from protocol.scenario.model import Scenario
from world.judge.clearance import Disks, Plane, gaps
from world.judge.contacts import Contacts
from world.judge.goals import Goals, LateralDeviation, tight
from world.judge.nearest import NearestGaps
from world.judge.phi import NavigationFunction
from world.judge.trajectory import TrajectoryDigest

_RISE = 1e-12  # an increase of phi below this is rounding
_BATCH = 32  # ticks put aside at most
_LARGEST = 1 << 14  # gaps measured at once at most: more would not stay in the processor's cache


@mypyc_attr(allow_interpreted_subclasses=True)
class Record:
    """Clearance, contacts, phi and digest of a trajectory.

    Args:
        parts: straight motions that a tick consists of.

    Attributes:
        goals: by which it measures; another one is set by `redirect`.
    """

    def __init__(self, scenario: Scenario, goals: Goals, positions: Sequence[Vector], parts: int = 1) -> None:
        disks = self._disks = Disks(scenario)
        self._gaps = NearestGaps(disks)
        self.goals = goals
        self._phi = NavigationFunction(disks, goals, scenario.k)
        self._digest = TrajectoryDigest(disks.ids)
        self._contacts = Contacts()
        self._deviation = LateralDeviation(goals)
        self._aside: list[tuple[Vector, ...]] = []
        self._parts = parts
        self._batch = parts * max(1, min(_BATCH, _LARGEST // parts // len(disks)))
        self._tick = 0  # of the newest configuration that is measured
        self._plane = as_plane([positions])
        self._increases = 0
        clearance, phi = float(gaps(disks, self._plane, self._plane).min()), self._phi(self._plane)[0]
        self._clearance, self.first_phi = clearance, phi
        self._digest.add([0], [positions])
        self._truth = Truth(0, disks.ids, tuple(positions), clearance, phi)
        self._news = [self._truth]

    def add(self, positions: Sequence[Vector], between: Sequence[tuple[Vector, ...]] = ()) -> None:
        """The configuration one tick later, reached by straight motion since the one before; if a tick has
        several parts, through those `between`."""
        self._aside.extend(between)
        self._aside.append(tuple(positions))
        if len(self._aside) >= self._batch:
            self._measure()

    def recast(self, scenario: Scenario, positions: Sequence[Vector], shapes: Mapping[int, Shape]) -> None:
        """Robots came and went: from the newest configuration on, which is `positions` now, those of another
        scenario are judged, among things of these shapes."""
        self._measure()
        self.goals.recast(scenario)
        disks = self._disks = Disks(scenario)
        disks.surround(shapes)
        self._gaps = NearestGaps(disks)
        self._phi = NavigationFunction(disks, self.goals, scenario.k)
        self._contacts.recast()
        self._digest.recast(disks.ids)  # from the next tick on
        self._deviation.recast()
        self._plane = as_plane([positions])
        clearance = float(gaps(disks, self._plane, self._plane).min())
        self._clearance = min(self._clearance, clearance)
        self._truth = Truth(self._tick, disks.ids, tuple(positions), clearance, self._phi(self._plane)[0])

    def redirect(self, robot: int, goal: Vector) -> None:
        """From the newest configuration on a robot is to go to `goal`, m; all before is measured by the old
        one."""
        self._measure()
        x, y = self._truth.positions[self._truth.robots.index(robot)]
        self.goals.change(robot, goal, (x, y))

    def surround(self, shapes: Mapping[int, Shape]) -> None:
        """From the newest configuration on these things stand, by number; all before is measured without."""
        self._measure()
        self._disks.surround(shapes)

    @property
    def tight(self) -> float | None:
        """Tightness of the present goals."""
        return tight(self._disks, self.goals)

    @property
    def truth(self) -> Truth:
        """The newest configuration."""
        self._measure()
        return self._truth

    @property
    def contacts(self) -> Contacts:
        """Overlaps so far."""
        self._measure()
        return self._contacts

    @property
    def clearance(self) -> float:
        """Smallest gap so far, over continuous time, m."""
        self._measure()
        return self._clearance

    @property
    def increases(self) -> int:
        """Number of ticks in which phi rose."""
        self._measure()
        return self._increases

    @property
    def deviation(self) -> list[float]:
        """Largest distance of each robot from its straight way so far, in the order of ids, m."""
        self._measure()
        return self._deviation()

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
        plane, parts = as_plane(aside), self._parts
        before = np.concatenate((self._plane, plane[:-1]))
        disks, during = self._gaps(before, plane)
        for row, nearest in enumerate(during):
            self._contacts.add(self._tick + row / parts, disks, nearest, before[row], plane[row], 1.0 / parts)
        self._tell(aside[parts - 1 :: parts], during.min(axis=1).reshape(-1, parts).min(axis=1).tolist())
        self._deviation.add(plane)
        self._plane = plane[-1:]

    def _tell(self, configurations: list[tuple[Vector, ...]], smallest: list[float]) -> None:
        """Take in the configurations at the ends of ticks, with the smallest gap in each of these."""
        values = self._phi(as_plane(configurations))
        for row, (positions, clearance, phi) in enumerate(zip(configurations, smallest, values, strict=True)):
            self._increases += phi > self._truth.phi + _RISE
            self._truth = Truth(self._tick + row + 1, self._disks.ids, positions, clearance, phi)
            self._news.append(self._truth)
        self._digest.add(range(self._tick + 1, self._tick + 1 + len(configurations)), configurations)
        self._clearance = min(self._clearance, *smallest)
        self._tick += len(configurations)


def as_plane(positions: Sequence[Sequence[Vector]]) -> Plane:
    """Configurations as complex numbers x + iy, shape (n, p)."""
    plane: Plane = np.array(positions).view(np.complex128)[..., 0]
    return plane
