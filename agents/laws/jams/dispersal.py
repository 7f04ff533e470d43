"""Dispersal: how jams come apart where there is room around them.

A crowd whose goals are on the far side of it presses itself together from all sides, and then nobody in it
can move before somebody else does, not even in a circle. So all but one spread from the jam's centroid to
twice the distance, stand there a while, and go on one after the other. And two at their goals may leave less
than a disk between them where another wants to pass: who stands at its goal steps aside in the same manner
for one that has been standing beside it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, final

from agents.laws.jams.giving_way import JAM, NEAR, GivingWay
from agents.navigation.deadlock import centroid, cluster
from agents.peers.state import PeerState
from protocol.messages import Vector

CROWD: Final = 8  # robots, from which on a jam does not resolve itself
# Laps:
WAIT: Final = 24.0  # that the second in line spreads and stands
QUEUE: Final = 2.0  # that each after it waits longer
STANDING: Final = 0.5  # radii, by which who stands moves at most while it is watched


@final
class Dispersal(GivingWay):
    """One robot's part in jams where nothing is narrow."""

    def __init__(self, robot: int, radius: float, lap: float, period: float) -> None:
        """See `GivingWay`."""
        super().__init__(robot, radius, lap, period)
        self._beside: dict[int, Vector] = {}  # who wanted to pass, and where it was, when last looked at

    def look(
        self, tick: int, position: Vector, left: float, peers: Sequence[PeerState], *, stuck: bool
    ) -> None:
        """Take in a tick in which the robot may go on.

        Args:
            position: own, m.
            left: length of the way to the goal, m.
            peers: who moves.
            stuck: whether the robot escapes from a deadlock.
        """
        if left <= NEAR * self._radius:
            self._look_beside(tick, position, peers)
            return
        self._beside = {}
        if not self._is_held(tick, left) or not stuck:
            return
        jam = _jam(position, self._radius, peers)
        if len(jam) + 1 < CROWD:
            return
        rank = len(self._before(tick, [peer for peer in jam if self._wants(peer)]))
        if rank > 0:
            self._back_off(tick, _spread(position, jam), WAIT + QUEUE * rank)

    def _look_beside(self, tick: int, position: Vector, peers: Sequence[PeerState]) -> None:
        """At the goal: step aside if somebody on its way has stood beside this robot since the last look."""
        self._nearest = math.inf
        if tick - self._since < JAM * self._lap:
            return
        self._since = tick
        jam = _jam(position, self._radius, peers)
        before = self._beside
        self._beside = {peer.robot: (peer.x, peer.y) for peer in jam if self._wants(peer)}
        for robot, place in self._beside.items():
            if robot in before and math.dist(place, before[robot]) < STANDING * self._radius:
                self._back_off(tick, _spread(position, jam), WAIT)
                return


def _jam(position: Vector, radius: float, peers: Sequence[PeerState]) -> list[PeerState]:
    return cluster(position, radius, [peer for peer in peers if peer.placed])


def _spread(position: Vector, jam: Sequence[PeerState]) -> Vector:
    """Twice as far from the centroid of the robot and its jam, m."""
    x, y = centroid([*[(peer.x, peer.y) for peer in jam], position])
    return 2.0 * position[0] - x, 2.0 * position[1] - y
