"""What one end of a pair's line says of it."""

from __future__ import annotations

from agents.lines.ends import Follower, Owner
from agents.lines.robot_pair import RobotPair
from protocol.messages import Answer, Proposal


def proposal_of(pair: RobotPair) -> Proposal | None:
    """What an owner says while anything that it proposed is unanswered: the newest of that.

    An answer to it settles all before it, so those need not be said again if they were lost.
    """
    end = pair.end
    assert isinstance(end, Owner)
    if not end.proposed:
        return None
    number, line = next(reversed(end.proposed.items()))
    return Proposal(pair.peer, end.peer_incarnation, number, line.nx, line.ny, line.offset)


def answer_of(pair: RobotPair) -> Answer:
    """What a follower says of what it was offered."""
    end = pair.end
    assert isinstance(end, Follower)
    return Answer(pair.peer, end.peer_incarnation, end.held_number, end.seen)
