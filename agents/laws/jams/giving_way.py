"""Giving way: to back off from a jam for a while, so that others get through."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Final

from agents.navigation.deadlock import LAP
from agents.peers.state import PeerState
from protocol.messages import Vector

# Laps: in one the largest disk moves by its radius at full speed.
JAM: Final = 16.0  # without coming nearer to the goal by a radius
TURN: Final = 64.0  # until somebody else goes first
NEAR: Final = 2.0  # radii from its goal, within which a robot gets in nobody's way to get there


class GivingWay:
    """One robot's part in jams. What a jam is, and where to back off to, is a subclass's.

    Args:
        robot: its id.
        radius: its own, m.
        lap: time in which the largest disk moves by its radius at full speed, s.
        period: control period, s.
    """

    def __init__(self, robot: int, radius: float, lap: float, period: float) -> None:
        self._robot, self._radius = robot, radius
        self._lap = max(1, math.ceil(max(lap, 0.25 * LAP * period) / period))  # ticks
        self._goal: Vector | None = None
        self._nearest, self._since = math.inf, 0
        self._back: Vector | None = None
        self._until = 0

    def yielding(self, tick: int, goal: Vector) -> Vector | None:
        """Where the robot backs off to, m, while it gives way; None when it may go on to `goal` (m)."""
        if goal != self._goal:
            self._goal, self._back = goal, None
            self._nearest, self._since = math.inf, tick
        if self._back is not None and tick >= self._until:
            self._back, self._nearest, self._since = None, math.inf, tick
        return self._back

    def _back_off(self, tick: int, place: Vector, laps: float) -> None:
        self._back, self._until = place, tick + math.ceil(laps * self._lap)

    def _is_held(self, tick: int, left: float) -> bool:
        """Whether the robot has not come nearer to its goal for long; then it counts anew.

        Args:
            left: length of the way to the goal, m.
        """
        if left < self._nearest - self._radius:
            self._nearest, self._since = left, tick
        if tick - self._since < JAM * self._lap:
            return False
        self._since = tick
        return True

    def _wants(self, peer: PeerState) -> bool:
        """Whether a peer is still on its way to its goal."""
        return peer.placed and peer.gamma > (NEAR * self._radius) ** 2

    def _before(self, tick: int, jam: Iterable[PeerState]) -> list[PeerState]:
        """Those of these who go before this robot.

        It follows from ids and the tick, so all of a jam know it without a word. It is somebody else after a
        while, for whoever goes first may be the one that cannot.
        """
        turn = int(tick // (TURN * self._lap))
        own = _order(self._robot, turn)
        return [peer for peer in jam if _order(peer.robot, turn) < own]


def _order(robot: int, turn: int) -> int:
    """A permutation of ids that is another one in every turn."""
    return (robot * 7919 + turn * 104_729 * robot) % 1_000_003
