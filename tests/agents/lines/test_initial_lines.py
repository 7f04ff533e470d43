"""Lines that both know from the start positions: held without a word, and renewed a few at a time."""

import math

from agents.lines.negotiation.near import RENEWALS
from agents.lines.separating_lines import SeparatingLines
from agents.peers.state import addressed_to
from protocol.messages import Answer, Member, Proposal, State

ROBOTS = 16
RADII = dict.fromkeys(range(1, ROBOTS + 1), 0.02)
STARTS = {
    i: (0.8 * math.cos(math.tau * i / ROBOTS), 0.8 * math.sin(math.tau * i / ROBOTS)) for i in RADII
}  # far apart
MEMBERS = {i: Member(i, 7, "live", RADII[i], founding=7) for i in RADII}
DESIRED = (0.05, 0.02)


def ledger(robot: int) -> SeparatingLines:
    made = SeparatingLines(robot, 7, RADII, speed=0.1, period=0.05, members=MEMBERS, starts=STARTS)
    made.locate(0, STARTS[robot], 0.0)
    return made


def tell(
    listener: SeparatingLines,
    own: int,
    speaker: int,
    tick: int,
    proposals: tuple[Proposal, ...] = (),
    answers: tuple[Answer, ...] = (),
) -> None:
    state = State(
        speaker, 7, tick, STARTS[speaker], 0.0, 0.0, 0.0, DESIRED, proposals=proposals, answers=answers
    )
    listener.on_state(addressed_to(own, state, RADII[state.robot]))


def test_all_are_ready_before_a_word_is_said() -> None:
    assert all(ledger(robot).ready for robot in RADII)


def test_an_owner_renews_a_few_a_tick_until_all_are_renewed_once() -> None:
    owner = ledger(1)
    followers = {peer: ledger(peer) for peer in RADII if peer != 1}
    proposed: list[int] = []
    for tick in range(8):
        owner.locate(tick, STARTS[1], 0.0)
        for peer, follower in followers.items():
            _, answers = follower.entries(DESIRED)
            tell(owner, 1, peer, tick, answers=answers)
        proposals, _ = owner.entries(DESIRED)
        new = [each.peer for each in proposals if each.peer not in proposed]
        assert len(new) <= RENEWALS
        proposed += new
        for peer, follower in followers.items():
            tell(follower, peer, 1, tick, proposals)
    assert sorted(proposed) == sorted(followers)
    assert owner.entries(DESIRED) == ((), ())
    assert owner.ready


def test_the_lines_of_the_two_ends_are_the_same_from_the_start() -> None:
    (mine,) = (side for side in ledger(1).obeyed_lines() if side[0] == 2)
    (theirs,) = (side for side in ledger(2).obeyed_lines() if side[0] == 1)
    assert mine[1:] == (-theirs[1], -theirs[2], -theirs[3])
    owner = ledger(1)
    tell(owner, 1, 2, 0)
    assert mine in owner.obeyed_lines()


def test_a_state_is_kept_without_what_it_says_to_others() -> None:
    said = State(
        1,
        7,
        3,
        (0.1, 0.2),
        0.0,
        1.0,
        2.0,
        DESIRED,
        proposals=(Proposal(2, 7, 1, 1.0, 0.0, 0.0), Proposal(3, 7, 1, 0.0, 1.0, 5.0)),
        answers=(Answer(4, 7, 1, 1), Answer(2, 7, 0, 0)),
    )
    heard = addressed_to(2, said, 0.1)
    assert heard.proposals == said.proposals[:1]
    assert heard.answers == said.answers[1:]
