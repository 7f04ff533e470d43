"""A neighbour backs off from a new incarnation that stands too close for a line between both error bounds."""

import math

from agents.lines.separating_lines import SeparatingLines
from agents.peers.state import PeerState, addressed_to
from protocol.messages import Member, Proposal, State

RADII = {1: 0.04, 2: 0.04}
STILL = (0.0, 0.0)


def robot(identity: int, incarnation: int = 1) -> SeparatingLines:
    return SeparatingLines(identity, incarnation, RADII, speed=0.1, period=0.05)


def said(
    identity: int, incarnation: int, tick: int, x: float, bound: float, *proposals: Proposal
) -> PeerState:
    state = State(identity, incarnation, tick, (x, 0.0), bound, 0.0, 0.0, STILL, proposals, ())
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


def test_a_peer_with_a_line_is_left_to_the_line() -> None:
    ledger = robot(2)
    ledger.locate(0, (0.085, 0.0), 0.0001)
    ledger.on_state(said(1, 1, 0, 0.0, 0.0001, Proposal(2, 1, 1, 1.0, 0.0, 0.0425)))
    ledger.locate(1, (0.085, 0.0), 0.0001)
    ledger.on_state(said(1, 1, 1, 0.002, 0.003))
    assert ledger.make_room((-0.05, 0.0)) == (-0.05, 0.0)
