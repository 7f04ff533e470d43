"""What a State says of one pair."""

from __future__ import annotations

from agents.lines.bond import Bond
from agents.lines.pair import Follower, Owner
from protocol.messages import Answer, Proposal


def proposals_of(bond: Bond) -> list[Proposal]:
    """What an owner has to repeat until it is answered."""
    end = bond.end
    assert isinstance(end, Owner)
    return [
        Proposal(bond.peer, end.peer_life, number, line.nx, line.ny, line.offset)
        for number, line in end.proposed.items()
    ]


def answer_of(bond: Bond) -> Answer:
    """What a follower says of what it was offered."""
    end = bond.end
    assert isinstance(end, Follower)
    return Answer(bond.peer, end.peer_life, end.held_number, end.seen)
