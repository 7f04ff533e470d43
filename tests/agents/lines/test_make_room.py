"""A neighbour backs off from a new incarnation that stands too close for a line between both error bounds."""

import math

import pytest

from agents.lines.separating_lines import SeparatingLines
from agents.peers.state import PeerState, addressed_to
from protocol.messages import Member, Proposal, State

RADII = {1: 0.04, 2: 0.04}
STARTS = {1: (0.0, 0.0), 2: (0.081, 0.0)}
STILL = (0.0, 0.0)


def robot(identity: int) -> SeparatingLines:
    """One that has begun with its peer, and has heard nothing of it."""
    members = {peer: Member(peer, 1, "live", 0.04, founding=1) for peer in RADII}
    return SeparatingLines(identity, 1, RADII, speed=0.1, period=0.05, members=members, starts=STARTS)


def said(
    identity: int, incarnation: int, tick: int, x: float, bound: float, *proposals: Proposal
) -> PeerState:
    state = State(
        identity, incarnation, tick, (x, 0.0), bound, 0.0, 0.0, STILL, proposals=proposals, answers=()
    )
    return addressed_to(2, state, RADII[identity])


def test_no_room_is_asked_of_a_peer_that_is_far_enough() -> None:
    ledger = robot(1)
    ledger.locate(0, (0.0, 0.0), 0.001)
    ledger.on_state(said(2, 1, 0, 0.1, 0.003))
    ledger.on_state(said(2, 2, 1, 0.1, 0.003))
    assert ledger.make_room((0.02, 0.01)) == (0.02, 0.01)


def test_a_neighbour_backs_off_until_a_line_fits() -> None:
    ledger, position = robot(1), 0.0
    ledger.locate(0, (position, 0.0), 0.001)
    ledger.on_member(Member(2, 1, "standing", 0.04, (0.082, 0.0)))
    for tick in range(1, 9):
        ledger.on_state(said(2, 2, tick, 0.082, 0.003))
        vx, vy = ledger.make_room(STILL)
        assert vx <= 0.0
        assert vy == 0.0
        position += 0.05 * max(vx, -0.1)
        ledger.locate(tick, (position, 0.0), 0.001)
    assert math.isclose(position, -0.012, abs_tol=1e-6)  # both bounds and a quarter of the radius
    assert ledger.entries(STILL)[0]


def test_a_follower_backs_off_as_well() -> None:
    ledger = robot(2)
    ledger.locate(0, (0.082, 0.0), 0.003)
    ledger.on_state(said(1, 1, 0, 0.0, 0.001))
    ledger.on_state(said(1, 2, 1, 0.0, 0.001))
    vx, vy = ledger.make_room((-0.05, 0.03))
    assert vx > 0.0
    assert vy == 0.03


def test_the_first_life_of_a_peer_needs_no_more_room() -> None:
    ledger = robot(1)
    ledger.locate(0, (0.0, 0.0), 0.001)
    ledger.on_state(said(2, 1, 0, 0.081, 0.003))
    assert ledger.make_room((0.02, 0.01)) == (0.02, 0.01)


@pytest.mark.parametrize("identity", [1, 2])
@pytest.mark.parametrize("late", [False, True])
def test_a_robot_backs_off_from_a_peer_of_whose_first_life_it_heard_nothing_in_time(
    identity: int, late: bool
) -> None:
    peer = 3 - identity
    ledger = robot(identity)
    ledger.locate(0, STARTS[identity], 0.001)
    if late:  # the roster names the second life, and then the last word of the first arrives
        ledger.on_member(Member(peer, 2, "live", 0.04, founding=1))
        ledger.on_state(said(peer, 1, 0, STARTS[peer][0], 0.003))
    ledger.on_state(said(peer, 2, 1, STARTS[peer][0], 0.003))
    vx, _ = ledger.make_room(STILL)
    assert vx * (STARTS[identity][0] - STARTS[peer][0]) > 0.0


def test_a_peer_with_a_line_is_left_to_the_line() -> None:
    ledger = robot(2)
    ledger.locate(0, (0.085, 0.0), 0.0001)
    ledger.on_state(said(1, 1, 0, 0.0, 0.0001, Proposal(2, 1, 1, 1.0, 0.0, 0.0425)))
    ledger.locate(1, (0.085, 0.0), 0.0001)
    ledger.on_state(said(1, 1, 1, 0.002, 0.003))
    assert ledger.make_room((-0.05, 0.0)) == (-0.05, 0.0)
