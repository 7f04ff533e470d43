"""Deadlock: detect that a robot makes no progress, and leave along the direction of negative curvature.

A robot stops away from its goal at a saddle of phi, where repulsion cancels attraction, or when a filter
reduces its desired velocity to zero. At a saddle phi decreases when all members of a cluster circle its
centroid in one sense, v_i = J (b_i - centroid), J = [[0, 1], [-1, 0]] (Karagöz, Bozma, Koditschek, Prop.
C.4). The escape is a drift within the flow: the other disks and the workspace still repel the robot.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Final, TypeVar

from agents.peers.state import Peer
from protocol.messages import Vector

Other = TypeVar("Other", bound=Peer)
Mean = tuple[Vector, Vector]  # averaged once, averaged twice
MOTIONLESS: Mean = ((0.0, 0.0), (0.0, 0.0))

# The times below are for a lap of LAP (time for the largest disk to move by its radius) and a period of STEP.
# They scale with the lap. The window has at least eight periods, since an oscillation takes some periods; the
# other times have at least a quarter of the periods that they have here.
LAP: Final = 0.4  # s
STEP: Final = 0.05  # s
SLOW: Final = 0.1  # fraction of the free speed below which there is no progress
WINDOW: Final = 0.4  # s, time constant of the average motion, in which oscillations cancel
SWING: Final = 3.0  # growth of the window over the latency: late repulsion oscillates slowly
STALEST: Final = 2.0  # s, largest latency considered, so that a disconnected peer delays no others
PATIENCE: Final = 1.0  # s without progress before the escape, with fresh States
TRIPS: Final = 6.0  # growth of the patience over the latency: each change of lines takes a round trip
RISE: Final = 0.5  # s from no drift to full drift
BURST: Final = 3.0  # s, longest escape before the next patience, since a drift may hold a robot, too
RELEASE: Final = 1.0  # s from full drift to none, after progress or the end of a burst
FALL: Final = 0.98  # gamma has decreased when it is below this fraction of the last mark
ADJACENT: Final = 1.25  # closest neighbours: beta_ij <= eps = ADJACENT rho_ij^2, centres within 1.5 rho_ij


@dataclass
class Progress:
    """Detects from desired and executed motion that one robot is stuck.

    The free speed is that of attraction alone, min(speed, 2 s |b_i - g_i|). A robot stalls if it is away from
    its goal and moves along its desired velocity at less than a tenth of the free speed. If the desired
    velocity is that small, it may only wait for gamma to decrease: then it stalls if a disk blocks the
    straight line to its goal, or if gamma does not decrease.
    """

    period: float  # control period, s
    lap: float = 0.0  # time for the fleet's largest disk to move by its radius at full speed, s
    # Of the escape, 0 (none) to 1, continuous in time. The drift in the flow is strength * free speed *
    # `circling`: never more than the attraction, so that no robot orbits its goal.
    strength: float = 0.0
    _moved: Mean = MOTIONLESS
    _wanted: Mean = MOTIONLESS
    _free: float = 0.0
    _stalled: float = 0.0
    _quiet: float = 0.0
    _mark: float = math.inf

    def update(
        self,
        *,
        displacement: Vector,
        desired: Vector,
        free: float,
        gamma: float,
        barred: Callable[[], bool],
        latency: float = 0.0,
    ) -> float:
        """Update for one tick, and return the strength.

        Args:
            displacement: executed during the last tick, m.
            desired: velocity of the flow before drift and filter, m/s.
            free: free speed, m/s; 0 at the goal.
            gamma: sum of all robots' squared distances to their goals, m^2, as known.
            barred: evaluates `barred` for this tick, if needed.
            latency: age of the oldest State in use, s. The patience grows with it, since a filter that waits
                for answers holds a robot for some round trips without any deadlock.
        """
        laps, periods = self.lap / LAP, self.period / STEP
        scale = max(laps, min(periods, 1.0), 0.25 * periods)
        latency = min(latency, STALEST * max(1.0, scale))
        patience = PATIENCE * scale + TRIPS * latency
        weight = min(1.0, self.period / (WINDOW * max(laps, periods) + SWING * latency))
        moved = displacement[0] / self.period, displacement[1] / self.period
        self._moved = _average(self._moved, moved, weight)
        self._wanted = _average(self._wanted, desired, weight)
        self._free += weight * (free - self._free)
        self._quiet += self.period
        if gamma < FALL * self._mark:
            self._mark, self._quiet = gamma, 0.0
        stalls = free > 0.0 and self._stalls(barred, patience)
        self._stalled = self._stalled + self.period if stalls else 0.0
        begun = self._stalled - patience
        if 0.0 < begun <= BURST * scale:
            self.strength = min(1.0, self.strength + self.period / (RISE * scale))
        else:
            self.strength = max(0.0, self.strength - self.period / (RELEASE * scale))
        if begun > BURST * scale:
            self._stalled = 0.0
        return self.strength

    def _stalls(self, barred: Callable[[], bool], patience: float) -> bool:
        _, (wx, wy) = self._wanted
        _, (mx, my) = self._moved
        wanted = math.hypot(wx, wy)
        if wanted < SLOW * self._free:
            return barred() or self._quiet > patience
        return mx * wx + my * wy < SLOW * self._free * wanted


def barred(position: Vector, goal: Vector, radius: float, peers: Iterable[Peer]) -> bool:
    """Whether a peer's disk (as known) blocks this disk's straight line from position to goal (m)."""
    x, y = position
    wx, wy = goal[0] - x, goal[1] - y
    square = wx * wx + wy * wy
    for peer in peers:
        dx, dy = peer.x - x, peer.y - y
        along = dx * wx + dy * wy
        if along > 0.0 and square > 0.0:
            part = min(along / square, 1.0)
            if math.hypot(dx - part * wx, dy - part * wy) < radius + peer.radius:
                return True
    return False


def cluster(position: Vector, radius: float, peers: Sequence[Other]) -> list[Other]:
    """Peers in this robot's class of closest neighbours: the transitive closure of beta_ij <= eps."""
    members: list[Other] = []
    rest = list(peers)
    frontier = [(position[0], position[1], radius)]
    while frontier:
        x, y, own = frontier.pop()
        far: list[Other] = []
        for peer in rest:
            near_squared = (1.0 + ADJACENT) * (own + peer.radius) ** 2
            if (peer.x - x) ** 2 + (peer.y - y) ** 2 <= near_squared:
                members.append(peer)
                frontier.append((peer.x, peer.y, peer.radius))
            else:
                far.append(peer)
        rest = far
    return members


def circling(position: Vector, goal: Vector, radius: float, peers: Sequence[Peer]) -> Vector:
    """J (b_i - centroid), divided by its largest length in the cluster; alone, around the own goal."""
    members = [(peer.x, peer.y) for peer in cluster(position, radius, peers)]
    if members:
        members.append(position)
        cx, cy = centroid(members)
    else:
        members, (cx, cy) = [position], goal
    farthest = max(math.hypot(x - cx, y - cy) for x, y in members)
    if farthest == 0.0:
        return 0.0, 0.0
    return (position[1] - cy) / farthest, (cx - position[0]) / farthest


def centroid(points: Sequence[Vector]) -> Vector:
    """Mean of the points, m."""
    x, y = 0.0, 0.0  # `sum` rounds differently from Python 3.12 on
    for px, py in points:
        x, y = x + px, y + py
    return x / len(points), y / len(points)


def _average(mean: Mean, value: Vector, weight: float) -> Mean:
    """The exponential mean of an exponential mean: an oscillation of rate w fades by (w window)^2."""
    first = _toward(mean[0], value, weight)
    return first, _toward(mean[1], first, weight)


def _toward(mean: Vector, value: Vector, weight: float) -> Vector:
    return mean[0] + weight * (value[0] - mean[0]), mean[1] + weight * (value[1] - mean[1])
