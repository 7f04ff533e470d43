"""What States say of lines where much is lost: the newest offer, placed where its peer may be."""

from __future__ import annotations

import pytest

from agents.lines.ends import Owner
from agents.lines.separating_lines import SeparatingLines
from agents.peers.state import PeerState
from protocol.messages import Answer, Proposal

R, SPEED, STEP = 0.04, 0.1, 0.05  # m, m/s, s
LAP = 8  # ticks, in which a robot moves by its radius
STARTS = {1: (0.0, 0.0), 2: (0.32, 0.0)}  # the other drives at this one, which stands


def heard(robot: int, tick: int, x: float, vx: float, answers: tuple[Answer, ...] = ()) -> PeerState:
    return PeerState(robot, 1, tick, True, x, 0.0, 0.0, 1.0, 1.0, vx, 0.0, radius=R, answers=answers)


def owner(delay: int) -> SeparatingLines:
    """Robot 1, which has heard robot 2 in every tick so far, `delay` ticks late, and was answered."""
    made = SeparatingLines(1, 1, {1: R, 2: R}, speed=SPEED, period=STEP, starts=STARTS)
    for tick in range(20):
        made.locate(tick, STARTS[1], 0.0)
        made.entries((0.0, 0.0))
        peer = made._pairs[2].end
        said = tick - delay
        if said >= 0:
            answer = Answer(1, 1, peer.number, peer.number) if isinstance(peer, Owner) else None
            made.on_state(
                heard(2, said, STARTS[2][0] - said * SPEED * STEP, -SPEED, (answer,) if answer else ())
            )
    return made


def offered(lines: SeparatingLines, tick: int) -> Proposal:
    """By the State of a tick until which nothing was heard any more."""
    lines.locate(tick, STARTS[1], 0.0)
    (offer,), _ = lines.entries((0.0, 0.0))
    return offer


@pytest.mark.parametrize("delay", [0, 4])
def test_who_is_not_heard_is_not_reckoned_to_have_gone_on_for_ever(delay: int) -> None:
    soon, later, last = (offered(owner(delay), tick).offset for tick in (18 + LAP, 20 + LAP, 20 + 10 * LAP))
    assert later < soon - 1e-3  # room is left to it for as long as it is not heard,
    assert last == later  # but no more than it takes in a lap


def test_only_the_newest_of_what_is_unanswered_is_said() -> None:
    lines = owner(0)
    numbers = []
    for tick in range(26, 26 + LAP):
        lines.locate(tick, (0.001 * (tick - 20), 0.0), 0.0)
        (offer,), _ = lines.entries((0.0, 0.0))
        numbers.append(offer.number)
    end = lines._pairs[2].end
    assert isinstance(end, Owner)
    assert len(set(numbers)) > 2
    assert list(end.proposed) == sorted(set(numbers))  # and all are obeyed
