"""What a robot does differently once States are late: foresight, softer repulsion, more speed near goals.

- A peer that has much farther to go than the robot is taken to have gone on as it wished, and the robot makes
  room ahead of time (`foreseen`). Only one of two does that, for both would drive each other back; and some
  of the gap that was seen remains.
- The repulsive layer around a disk is about gamma/k thin. Near the goals it is thinner than the way of a peer
  before its State arrives: robots come so close that each waits until it sees the other leave, and lines give
  them no more speed than gap over latency. A smaller k (`late_gain`) keeps them farther apart, for a path
  that is a little longer. Far from the goals it would only widen detours.
- Each robot takes the common pace from where the others were. Near its goal, where gaps hold it back and not
  the way of others, a robot goes faster (`late_speed`).

Latencies are in laps: in a lap the largest disk moves by its radius at full speed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from agents.peers.state import Peer, PeerState

FIRST: Final = 2.0  # times the own gamma, above which a peer goes first
KEPT: Final = 0.25  # of the gap seen, that a peer is not taken to have closed
LONGEST: Final = 1.0  # laps, for which a wish is followed
SOFTER: Final = 0.7  # k is divided by one plus this, for States that are a lap late
LATEST: Final = 1.0  # laps, beyond which later States change neither gain nor speed
SOFT_IN_FULL: Final = 1.5  # radii from the goal, within which the gain is softened in full
SOFT_AT_ALL: Final = 3.5  # radii from the goal, beyond which it is not
HASTE: Final = 0.6  # of the speed limit, for States that are a lap late or more
FAST_IN_FULL: Final = 4.0  # radii from the goal, within which haste counts in full
FAST_AT_ALL: Final = 6.0  # radii from the goal, beyond which it does not


def foreseen(me: Peer, peers: Sequence[Peer], tick: int, period: float, lap: float) -> list[Peer]:
    """All peers as last heard, those that go first moved on by their wishes since then.

    Args:
        period, lap: of a tick, and of a lap, s.
    """
    found: list[Peer] = []
    for peer in peers:
        if isinstance(peer, PeerState) and peer.gamma > FIRST * me.gamma:
            age = min((tick - peer.tick) * period, LONGEST * lap)
            found.append(_moved_on(me, peer, peer.vx * age, peer.vy * age))
        else:
            found.append(peer)
    return found


def _moved_on(me: Peer, peer: Peer, wx: float, wy: float) -> Peer:
    """The peer after the way (wx, wy), m, or as much of it as leaves enough of the gap."""
    rx, ry = peer.x - me.x, peer.y - me.y
    distance, contact = math.hypot(rx, ry), me.radius + peer.radius
    if distance <= contact:
        return peer
    near = contact + KEPT * (distance - contact)
    square, closing = wx * wx + wy * wy, -(rx * wx + ry * wy)
    discriminant = closing * closing - square * (distance * distance - near * near)
    part = 1.0
    if closing > 0.0 and square > 0.0 and discriminant >= 0.0:
        part = min(1.0, (closing - math.sqrt(discriminant)) / square)
    return Peer(peer.x + part * wx, peer.y + part * wy, peer.radius, peer.gamma)


def late_gain(k: float, away: float, latency: float) -> float:
    """The exponent k for a robot `away` (own radii) from its goal, if the oldest State that it uses is
    `latency` laps old."""
    return k / (1.0 + SOFTER * _near(away, SOFT_IN_FULL, SOFT_AT_ALL) * min(latency, LATEST))


def late_speed(speed: float, away: float, latency: float) -> float:
    """The speed for `common_pace` of a robot `away` (own radii) from its goal, m/s; its limit stays."""
    return speed * (1.0 + HASTE * _near(away, FAST_IN_FULL, FAST_AT_ALL) * min(LATEST, latency))


def _near(away: float, wholly: float, at_all: float) -> float:
    """1 within the first distance, 0 beyond the second, in between linear."""
    return min(1.0, max(0.0, (at_all - away) / (at_all - wholly)))
