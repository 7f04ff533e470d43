"""What a State says of lines: of one pair, and of all together no more than a State has room for."""

from __future__ import annotations

from collections import Counter
from typing import Final

from agents.lines.ends import Follower, Owner
from agents.lines.robot_pair import RobotPair
from protocol.messages import Answer, Proposal
from protocol.streams import STREAMS

# Bytes at most, every integer as long as it may become.
_HEAD: Final = 256  # of a State without lines
_PROPOSAL: Final = 51
_ANSWER: Final = 33
_LIMIT: Final = STREAMS["state"].limit


def proposals_of(pair: RobotPair) -> list[Proposal]:
    """What an owner has to repeat until it is answered."""
    end = pair.end
    assert isinstance(end, Owner)
    return [
        Proposal(pair.peer, end.peer_incarnation, number, line.nx, line.ny, line.offset)
        for number, line in end.proposed.items()
    ]


def answer_of(pair: RobotPair) -> Answer:
    """What a follower says of what it was offered."""
    end = pair.end
    assert isinstance(end, Follower)
    return Answer(pair.peer, end.peer_incarnation, end.held_number, end.seen)


def fitting(proposals: list[Proposal], answers: int) -> list[Proposal]:
    """As many of the proposals as a State with so many `answers` has room for: the newest of every pair,
    and the same number of older ones of each.

    None has to be repeated: an answer to the newest settles all before it.

    Args:
        proposals: pair by pair, of each in the order of their numbers.
        answers: how many; together with the pairs at most 999.
    """
    room = (_LIMIT - _HEAD - _ANSWER * answers) // _PROPOSAL
    if len(proposals) <= room:
        return proposals
    newer: Counter[int] = Counter()  # by peer, than the one that is looked at
    ages = []
    for offer in reversed(proposals):
        ages.append(newer[offer.peer])
        newer[offer.peer] += 1
    ages.reverse()
    of_age = Counter(ages)
    depth, fit = 1, of_age[0]
    while fit + of_age[depth] <= room:
        fit += of_age[depth]
        depth += 1
    return [offer for offer, age in zip(proposals, ages, strict=True) if age < depth]
