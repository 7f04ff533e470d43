"""Where this robot is, and how far from that it can be at most: set-membership with disks.

A measurement says: at tick `stamp` the truth was within `error` of `position`. Odometry, which is
immediate and exact, carries that disk to the present. The truth lies in the new disk and in the one
known before, so in the smallest disk around their intersection.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Final, final

from mypy_extensions import mypyc_attr

from protocol.messages import Measurement

HISTORY: Final = 1024  # ticks of odometry that are kept; a measurement older than that is ignored
_TOUCH: Final = 1e-9  # m; disks this far apart still count as touching

Vector = tuple[float, float]


@final
@mypyc_attr(acyclic=True)
class Disk:
    """All points within `radius` of (x, y), m."""

    __slots__ = ("radius", "x", "y")

    def __init__(self, x: float, y: float, radius: float) -> None:
        self.x, self.y, self.radius = x, y, radius


class Estimate:
    """The own position with a guaranteed error bound.

    Args:
        error: largest error of a measurement, noise bound plus bias, m.
        reach: the most that the robot can really move in one tick, m; what is assumed of a tick
            whose odometry was missed.
    """

    def __init__(self, error: float, reach: float) -> None:
        self._error = error
        self._reach = reach
        self._tick: int | None = None
        self._disk: Disk | None = None
        self._history: deque[Disk] = deque(maxlen=HISTORY)  # how far each past tick led, newest last

    @property
    def known(self) -> bool:
        """Whether any measurement has come in yet."""
        return self._disk is not None

    @property
    def position(self) -> Vector | None:
        """Centre of the disk that holds the truth, m."""
        return None if self._disk is None else (self._disk.x, self._disk.y)

    @property
    def bound(self) -> float:
        """Radius of that disk, m; infinite as long as nothing is known."""
        return math.inf if self._disk is None else self._disk.radius

    def update(self, measurement: Measurement) -> None:
        """Take in one tick's odometry and measurement; a tick that is not newer is ignored.

        Nothing is known of moves before the first tick of this life, so a measurement older than that is
        of no use.
        """
        if self._tick is not None:
            if measurement.tick <= self._tick:
                return
            self._move(measurement.displacement, measurement.tick - self._tick)
        self._tick = measurement.tick
        if measurement.position is not None:
            seen = self._carried(measurement.position, measurement.tick - measurement.stamp)
            if seen is not None:
                self._disk = seen if self._disk is None else intersection(self._disk, seen)

    def _move(self, displacement: Vector, passed: int) -> None:
        """Apply odometry. Of missed ticks only the first can have moved it: there was no command after."""
        moves = [Disk(0.0, 0.0, 0.0)] * min(passed - 1, HISTORY)
        if moves:
            moves[0] = Disk(0.0, 0.0, self._reach)
        moves.append(Disk(*displacement, 0.0))
        self._history.extend(moves)
        for move in moves:
            if self._disk is not None:
                self._disk = _sum(self._disk, move)

    def _carried(self, position: Vector, age: int) -> Disk | None:
        """The disk that a measurement of `age` ticks ago leaves for the present."""
        if not 0 <= age <= len(self._history):
            return None
        disk = Disk(*position, self._error)
        for back in range(-age, 0):
            disk = _sum(disk, self._history[back])
        return disk


def _sum(disk: Disk, move: Disk) -> Disk:
    """Where a point of `disk` can be after a displacement out of `move`."""
    return Disk(disk.x + move.x, disk.y + move.y, disk.radius + move.radius)


def intersection(one: Disk, other: Disk) -> Disk:
    """The smallest disk around what two disks share.

    Disks that share nothing contradict each other, which the stated bounds exclude; the smallest disk
    around both then loses neither.
    """
    small, large = (one, other) if one.radius < other.radius else (other, one)
    dx, dy = large.x - small.x, large.y - small.y
    distance = math.hypot(dx, dy)
    apart = distance - small.radius - large.radius
    if apart > _TOUCH:
        radius = 0.5 * (distance + small.radius + large.radius)
        return _between(small, dx / distance, dy / distance, radius - small.radius, radius)
    chord = 0.5 * (distance * distance + small.radius**2 - large.radius**2)  # times distance, from small
    if chord <= 0.0 or small.radius == 0.0:
        return small
    along = min(chord / distance, small.radius)
    half = math.sqrt((small.radius - along) * (small.radius + along))
    return _between(small, dx / distance, dy / distance, along, half + max(0.0, apart))


def _between(start: Disk, nx: float, ny: float, along: float, radius: float) -> Disk:
    return Disk(start.x + along * nx, start.y + along * ny, radius)
