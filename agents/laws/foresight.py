"""Where peers that go first are taken to be, once their States are late.

A robot that gives way to what it has heard of gives way too late. So a peer that has much farther to go than
the robot is taken to have gone on as it wished, and the robot makes room ahead of time. Only one of two does
that, for both together would drive each other back; and some of the gap that was seen always remains.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from agents.navigation.slice import Peer
from agents.peers.state import PeerState

FIRST: Final = 2.0  # times the own gamma, above which a peer goes first
KEPT: Final = 0.25  # of the gap seen, that a peer is not taken to have closed
LONGEST: Final = 1.0  # laps, for which a wish is followed


def foreseen(me: Peer, peers: Sequence[Peer], tick: int, period: float, lap: float) -> list[Peer]:
    """All peers, those that go first where their wishes have taken them since their States.

    Args:
        me: this robot.
        peers: as last heard.
        tick: the present one.
        period: control period, s.
        lap: time in which the largest disk moves by its radius at full speed, s.
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
