"""Which pairs of one robot have to be looked at in a tick.

In a large fleet nearly all pairs agree on lines that are far. To look at each of them in every tick costs
more than all that is computed from those that are near: each lies elsewhere in memory. So they sleep until
the robot has gone as far as it may before it can come near one of their lines, or something else is obeyed.
"""

from __future__ import annotations

import math
from typing import final

from agents.lines.line import ROUNDING
from agents.lines.robot_pair import RobotPair


@final
class Watch:
    """All pairs of one robot.

    Args:
        ahead: way (m) that the own centre may go before pairs that sleep are looked at again.

    Attributes:
        each: all of them, in the order in which they came or, with `sort`, of their peers' ids.
        woken: where a pair puts itself that has to be looked at again.
    """

    __slots__ = ("_ahead", "_awake", "_reach", "_x", "_y", "each", "woken")

    def __init__(self, ahead: float) -> None:
        self.each: list[RobotPair] = []
        self.woken: list[RobotPair] = []
        self._ahead = ahead
        self._awake: list[RobotPair] = []
        self._x = self._y = 0.0  # own centre when the others fell asleep, m
        self._reach = -1.0  # gap (m) that their lines left there at least

    def add(self, pair: RobotPair) -> None:
        """There is another pair."""
        self.each.append(pair)
        self.woken.append(pair)

    def sort(self) -> None:
        """By peer, as if all had been there from the beginning."""
        self.each.sort(key=_peer_of)

    def awake(self) -> list[RobotPair]:
        """All that are not asleep; the others are ready."""
        if self.woken:
            self.woken.clear()
            self._awake = [pair for pair in self.each if not pair.asleep]
        return self._awake

    def near(self, x: float, y: float, reach: float) -> list[RobotPair]:
        """Every pair that obeys something less than `reach` (m) from the own centre at (x, y), m, and some
        more."""
        if math.hypot(x - self._x, y - self._y) + reach > self._reach:
            self._fall_asleep(x, y, reach + self._ahead)
        return self.awake()

    def _fall_asleep(self, x: float, y: float, reach: float) -> None:
        self._x, self._y, self._reach = x, y, reach if reach < math.inf else -1.0
        for pair in self.each:
            pair.asleep = pair.is_far(x, y, reach + ROUNDING)
        self.woken.clear()
        self._awake = [pair for pair in self.each if not pair.asleep]


def _peer_of(pair: RobotPair) -> int:
    return pair.peer
