"""Adaptations to late States: extrapolation of peers, softer repulsion and more speed near goals.

- A peer with a much longer remaining path than the robot is extrapolated by its wish, and the robot makes
  room ahead of time (`foreseen`). Only one of two does that, since both would drive each other back; and a
  part of the received gap remains.
- The repulsive layer around a disk is about gamma/k thin. Near the goals it is thinner than the motion of a
  peer before its State arrives: robots come so close that each waits until the other leaves, and lines allow
  them no more speed than gap over latency. A smaller k (`late_gain`) keeps them farther apart, for a slightly
  longer path. Far from the goals it would only widen detours.
- Each robot computes the common pace from past positions of the others. Near its goal, where gaps and not the
  others' motion limit it, a robot goes faster (`late_speed`).

Latencies are in laps: in a lap the largest disk moves by its radius at full speed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from agents.peers.state import Peer, PeerState

FIRST: Final = 2.0  # a peer with more than this times the own gamma is extrapolated
KEPT: Final = 0.25  # share of the received gap that extrapolation leaves
LONGEST: Final = 1.0  # laps, longest extrapolation
SOFTER: Final = 0.7  # k is divided by 1 + this for States that are a lap late
LATEST: Final = 1.0  # laps, largest latency considered
SOFT_IN_FULL: Final = 1.5  # radii from the goal with full effect on the gain
SOFT_AT_ALL: Final = 3.5  # radii from the goal without effect
HASTE: Final = 0.6  # additional speed over the speed limit, for States that are a lap late or more
FAST_IN_FULL: Final = 4.0  # radii from the goal with full effect on the speed
FAST_AT_ALL: Final = 6.0  # radii from the goal without effect


def foreseen(me: Peer, peers: Sequence[Peer], tick: int, period: float, lap: float) -> list[Peer]:
    """All peers as last received, some extrapolated by their wishes; `period` and `lap` in s."""
    found: list[Peer] = []
    for peer in peers:
        if isinstance(peer, PeerState) and peer.gamma > FIRST * me.gamma:
            age = min((tick - peer.tick) * period, LONGEST * lap)
            found.append(_moved_on(me, peer, peer.vx * age, peer.vy * age))
        else:
            found.append(peer)
    return found


def _moved_on(me: Peer, peer: Peer, wx: float, wy: float) -> Peer:
    """The peer after the motion (wx, wy), m, or the part of it that leaves enough of the gap."""
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


def late_gain(k: float, distance: float, latency: float) -> float:
    """Exponent k at `distance` (own radii) from the goal, if the oldest State is `latency` laps old."""
    return k / (1.0 + SOFTER * _near(distance, SOFT_IN_FULL, SOFT_AT_ALL) * min(latency, LATEST))


def late_speed(speed: float, distance: float, latency: float) -> float:
    """Speed for `common_pace` at `distance` (own radii) from the goal, m/s; the speed limit still holds."""
    return speed * (1.0 + HASTE * _near(distance, FAST_IN_FULL, FAST_AT_ALL) * min(LATEST, latency))


def _near(distance: float, wholly: float, at_all: float) -> float:
    """1 within the first distance, 0 beyond the second, linear in between."""
    return min(1.0, max(0.0, (at_all - distance) / (at_all - wholly)))
