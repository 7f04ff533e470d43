"""Who goes first, and where they go, as far as a robot can tell.

Whoever carries a part goes before who fetches one, and that one before who does neither; of two of a kind the
lower id goes first, of those that do neither the one farther from where it rests.
"""

from __future__ import annotations

import math

from agents.movers.outlook import Outlook
from agents.movers.traffic import Traveller
from agents.peers.state import PeerState
from protocol.messages import Claim
from protocol.scenario.model import Scenario

Vector = tuple[float, float]


def first(outlook: Outlook, robot: int, claim: Claim | None, position: Vector) -> list[PeerState]:
    """Peers that go before a robot which claims this and is there, m."""
    mine = _rank(outlook, robot, claim, position)
    return [peer for peer in outlook.peers if _rank(outlook, peer.robot, peer.claim, peer.position) < mine]


def traveller(scenario: Scenario, outlook: Outlook, peer: PeerState) -> Traveller | None:
    """A peer on its way; None where it has not said where it is."""
    if peer.position is None:
        return None
    part = 0 if peer.claim is None else peer.claim.part
    if not 0 < part <= len(scenario.parts):
        return Traveller(
            peer.position, outlook.home(peer.robot) or peer.position, peer.radius, outlook.among(0)
        )
    spec, carries = scenario.parts[part - 1], outlook.carriers.get(peer.robot) == part
    to = spec.goal if carries else outlook.floor.parts.get(part, peer.position)
    radius = max(peer.radius, spec.radius) if carries else peer.radius
    return Traveller(peer.position, to, radius, outlook.among(part))


def _rank(outlook: Outlook, robot: int, claim: Claim | None, at: Vector | None) -> tuple[int, float, int]:
    if robot in outlook.carriers:
        return 0, 0.0, robot
    if claim is not None:
        return 1, 0.0, robot
    return 2, 0.0 if at is None else -math.dist(at, outlook.home(robot) or at), robot
