"""How long robots stand after a blow, as somebody sees who only watches where the disks really are."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from math import dist
from typing import NamedTuple

from protocol.messages import Truth, Vector

AGAIN = 5.0  # s after which a robot that was started again, or is reached again, moves
MOVES = 1e-5  # m in a tick, from which on a disk counts as moving
_UNDER_WAY = 0.1  # m, at least, to the goal of who is to be hit: it must not arrive before it moves again
_SETTLING = 0.15  # s after a blow: what was commanded before is carried out, and told, by then
_GAP = 0.3  # s between truths, from which on a disk may have moved before the blow
_KEPT = 1000  # recoveries, so that a long trial does not grow by what it found


class Recovered(NamedTuple):
    """A robot moved again."""

    what: str
    robot: int
    seconds: float  # from the end of the blow


class _Hit(NamedTuple):
    what: str
    began: float  # s, when it could move again at the earliest


@dataclass
class Recovery:
    """Told of every blow and of every truth.

    Attributes:
        goals: where robots go in the present run, m.
        recovered: the last of them.
        count, worst: of all, and by what was done the longest, s.
    """

    goals: Mapping[int, Vector] = field(default_factory=dict)
    recovered: deque[Recovered] = field(default_factory=lambda: deque(maxlen=_KEPT))
    count: int = 0
    worst: dict[str, float] = field(default_factory=dict)
    _hits: dict[int, _Hit] = field(default_factory=dict)
    _before: dict[int, Vector] = field(default_factory=dict)
    _tick: int = -1
    _seen: float = 0.0  # s, when the last truth was
    _moving: frozenset[int] = frozenset()

    @property
    def standing(self) -> Mapping[int, str]:
        """Who has not moved again, and what was done."""
        return {robot: hit.what for robot, hit in self._hits.items()}

    @property
    def under_way(self) -> frozenset[int]:
        """Robots that move, have some way to go, and have got over whatever was done to them."""
        far = {
            robot for robot in self._moving & self.goals.keys()
            if dist(self._before[robot], self.goals[robot]) >= _UNDER_WAY
        }  # fmt: skip
        return frozenset(far.difference(self._hits))

    def hit(self, what: str, robots: Iterable[int], now: float) -> None:
        """Something is done to robots that ends `now` (s, monotonic), or later."""
        for robot in robots:
            self._hits[robot] = _Hit(what, now)

    def see(self, truth: Truth, now: float) -> None:
        """Where everybody is, as it was heard."""
        if truth.tick < self._tick or now > self._seen + _GAP:
            self._before = {}  # of another run, or before nothing was heard for a while
        where = dict(zip(truth.robots, truth.positions, strict=True))
        self._moving = frozenset(
            robot for robot, place in where.items()
            if robot in self._before and dist(place, self._before[robot]) >= MOVES
        )  # fmt: skip
        self._before, self._tick, self._seen = where, truth.tick, now
        for robot in self._moving & self._hits.keys():
            hit = self._hits[robot]
            if now >= hit.began + _SETTLING:
                del self._hits[robot]
                self._add(Recovered(hit.what, robot, now - hit.began))

    def _add(self, recovered: Recovered) -> None:
        self.recovered.append(recovered)
        self.count += 1
        self.worst[recovered.what] = max(self.worst.get(recovered.what, 0.0), recovered.seconds)
