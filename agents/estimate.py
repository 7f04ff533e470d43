"""Set-membership estimate of this robot's position, by a convex polygon.

A measurement says: at tick `stamp` the truth was within `bound` of `position`. Odometry, which is immediate
and off by at most its own bound, carries that to the present. So the truth lies in every such disk at once;
workspace and obeyed lines cut the set further (`confine`). An empty set says that a stated bound is wrong.
Measurements with bound 0 reduce the set to a point.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Final

from agents.lines.own_set import DIRECTIONS, SIDES, Polygon, around
from protocol.geometry import Disk
from protocol.line import ROUNDING, HalfPlane
from protocol.messages import Sense, Vector

HISTORY: Final = 64  # ticks of odometry that are kept at least; a measurement older than kept is ignored
_ULP: Final = 4.0 * 2.0**-53  # of |x| + |y|, which a tick's addition loses in truth and estimate


class Estimate:
    """The own position as the set of all possible positions.

    Args:
        max_step: the longest way from a velocity for one tick until the robot stands, m, which is assumed of
            ticks without odometry.
        trusting: whether to reset to the newest measurement when two contradict each other.
        coasts: whether it may move on in ticks without a command, `max_step` in all.
        oldest: age of the oldest measurement that may come, ticks.
    """

    def __init__(
        self, max_step: float, trusting: bool = False, oldest: int = 0, coasts: bool = False
    ) -> None:
        # Radius of a disk around `position` that contains the set, m; infinite until anything is known.
        self.bound = math.inf
        self.shape: Polygon | None = None  # the set as seen from `position`; None for a point
        self.contradiction = ""  # names the first two contradicting measurements; "" if none
        self._max_step = max_step
        self._trusting = trusting
        self._coast = max_step if coasts else 0.0
        self._tick: int | None = None
        self.x = self.y = 0.0  # a centre of the set, m, once anything is known
        self._extents = [0.0] * SIDES  # of the shape, in the fixed directions
        self._sources = [""] * SIDES  # the constraint behind each
        self._newest = 0  # tick of the measurement behind the initial set
        self._slack = ROUNDING
        self._kept = max(HISTORY, oldest)
        self._history: deque[Disk] = deque(maxlen=self._kept)  # of past ticks' displacements, newest last

    @property
    def lost(self) -> bool:
        """Whether measurements contradict each other, so that no position is certain."""
        return self.contradiction != "" and not self._trusting

    @property
    def position(self) -> Vector | None:
        """A centre of the set, m."""
        return (self.x, self.y) if self.bound < math.inf else None

    def update(self, tick: int, sense: Sense) -> None:
        """Take in the odometry and the measurement of `tick`, newer than all before. A measurement of before
        this life is of no use, as no odometry carries it on."""
        if self._tick is not None:
            self._move(sense, tick - self._tick)
        self._tick = tick
        if sense.position is not None and not self.lost:
            seen = self._carried(sense.position, sense.bound, tick - sense.stamp)
            if seen is not None:
                self._learn(seen, sense.stamp)

    def confine(self, side: HalfPlane, source: str) -> bool:
        """Intersect the set with a half-plane, named `source` in messages; returns whether it shrinks."""
        if self.shape is None or self.lost:
            return False
        limit = side.slack(self.x, self.y)
        if self.shape.extent(side.nx, side.ny) <= limit + 2.0 * self._slack:
            return False
        left = self.shape.cut(side.nx, side.ny, limit)
        if left is None:
            opposite = [side.nx * nx + side.ny * ny for nx, ny in DIRECTIONS]
            gap = -self.shape.extent(-side.nx, -side.ny) - limit
            self._report(source, self._sources[opposite.index(min(opposite))], gap)
            return False
        self._settle(left, source)
        return True

    def _move(self, sense: Sense, passed: int) -> None:
        """Apply odometry. Missed ticks had no command but the first: together they led at most `max_step`."""
        if passed > 1:
            self._history.append(Disk(0.0, 0.0, self._max_step))
            self._history.extend([Disk(0.0, 0.0, self._coast)] * min(passed - 2, self._kept))
            self._widen(self._max_step)
        dx, dy = sense.displacement
        self._history.append(Disk(dx, dy, sense.displacement_bound))
        if sense.displacement_bound > 0.0:
            self._widen(sense.displacement_bound)
        if self.bound == math.inf:
            return
        self.x += dx
        self.y += dy
        self._slack += _ULP * (abs(self.x) + abs(self.y))
        if self.shape is not None:
            self.shape.margin = self._slack
            self.bound = self.shape.radius

    def _widen(self, by: float) -> None:
        """Add a motion of at most `by` m in an unknown direction."""
        if self.shape is not None:
            self._settle(self.shape.widened(by), "")
        elif self.bound < math.inf:
            self._begin(Disk(self.x, self.y, by), self._newest)

    def _carried(self, position: Vector, bound: float, age: int) -> Disk | None:
        """A measurement of `age` ticks ago, carried to the present; None if that is too old."""
        if not 0 <= age <= len(self._history):
            return None
        x, y = position
        spread = bound
        for back in range(-age, 0):
            move = self._history[back]
            x, y, spread = x + move.x, y + move.y, spread + move.radius
        if spread > 0.0:
            spread += age * _ULP * (abs(x) + abs(y))
        return Disk(x, y, spread)

    def _learn(self, seen: Disk, stamp: int) -> None:
        """Apply that the truth is within `seen.radius` of `seen`."""
        if self.bound == math.inf:
            self._begin(seen, stamp)
            return
        dx, dy = seen.x - self.x, seen.y - self.y
        if self.shape is not None and seen.radius > 0.0:
            if math.hypot(dx, dy) + self.bound > seen.radius:  # otherwise it contains the set
                self._intersect(seen, dx, dy, stamp)
        elif self._apart(dx, dy, seen.radius) > self._slack:
            self._contradict(seen, dx, dy, stamp)
        elif seen.radius == 0.0:
            self._begin(seen, stamp)

    def _begin(self, seen: Disk, stamp: int) -> None:
        """Start from this alone."""
        self.x, self.y = seen.x, seen.y
        self._newest = stamp
        if seen.radius == 0.0:
            self.shape, self.bound = None, 0.0
            return
        self.shape = around(seen.radius, self._slack)
        self.bound = self.shape.radius
        self._extents = self.shape.extents()
        self._sources = [_of(stamp)] * SIDES

    def _intersect(self, seen: Disk, dx: float, dy: float, stamp: int) -> None:
        """Cut the set with the polygon around a disk whose centre is (dx, dy) away, m."""
        assert self.shape is not None
        left: Polygon | None = self.shape
        for side, (nx, ny) in enumerate(DIRECTIONS):
            limit = nx * dx + ny * dy + seen.radius
            if left is not None and limit + 2.0 * self._slack < self._extents[side]:
                left = left.cut(nx, ny, limit)
        if left is None:
            self._contradict(seen, dx, dy, stamp)
        elif left is not self.shape:
            self._settle(left, _of(stamp))

    def _settle(self, left: Polygon, source: str) -> None:
        """Replace the set by its part `left`, because of `source`, and centre it."""
        x, y = self.x, self.y
        ahead_x, ahead_y = left.centre()
        self.x += ahead_x
        self.y += ahead_y
        cx, cy = self.x - x, self.y - y  # the rounded displacement of the centre
        self.shape = left.shifted(-cx, -cy)
        self.bound = self.shape.radius
        before, self._extents = self._extents, self.shape.extents()
        for side, (nx, ny) in enumerate(DIRECTIONS):
            if self._extents[side] + nx * cx + ny * cy < before[side]:
                self._sources[side] = source

    def _apart(self, dx: float, dy: float, spread: float) -> float:
        """Gap between the set and a disk whose centre is (dx, dy) away, m; negative if they overlap."""
        if self.shape is None:
            return math.hypot(dx, dy) - spread
        return max(self._gaps(dx, dy, spread))

    def _gaps(self, dx: float, dy: float, spread: float) -> list[float]:
        return [
            -self._extents[(side + SIDES // 2) % SIDES] - (nx * dx + ny * dy + spread)
            for side, (nx, ny) in enumerate(DIRECTIONS)
        ]

    def _contradict(self, seen: Disk, dx: float, dy: float, stamp: int) -> None:
        other, gap = _of(self._newest), self._apart(dx, dy, seen.radius)
        if self.shape is not None:
            gaps = self._gaps(dx, dy, seen.radius)
            other = self._sources[(gaps.index(gap) + SIDES // 2) % SIDES]
        self._report(_of(stamp), other, gap)
        if self._trusting:
            self._begin(seen, stamp)

    def _report(self, one: str, other: str, gap: float) -> None:
        self.contradiction = f"{one} and {other} exclude each other by {gap:.2g} m: a stated bound is wrong"


def _of(stamp: int) -> str:
    return f"the measurement of tick {stamp}"
