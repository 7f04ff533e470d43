"""Who goes first, and where they go, as far as a robot can tell.

Whoever carries a part goes before who fetches one, and that one before who does neither; of two of a kind the
lower id goes first. Nothing of this depends on where they are: two that change places in it as they move
would keep each other where they are.
"""

from __future__ import annotations

from agents.movers.outlook import Outlook
from agents.movers.traffic import Traveller
from agents.peers.state import PeerState
from protocol.geometry import Disk
from protocol.messages import Claim
from protocol.scenario.model import Scenario


def first(outlook: Outlook, robot: int, claim: Claim | None) -> list[PeerState]:
    """Peers that go before a robot which claims this."""
    mine = _rank(outlook, robot, claim)
    return [peer for peer in outlook.peers if _rank(outlook, peer.robot, peer.claim) < mine]


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
    leaves = (Disk(*spec.goal, spec.radius),) if carries else ()
    return Traveller(peer.position, to, radius, outlook.among(part), leaves)


def _rank(outlook: Outlook, robot: int, claim: Claim | None) -> tuple[int, int]:
    if robot in outlook.carriers:
        return 0, robot
    return 2 if claim is None else 1, robot
