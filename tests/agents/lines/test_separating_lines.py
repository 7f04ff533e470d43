"""What one robot obeys of what the ledger says, and what it asks of the ledger and its peers."""

import math

import pytest

from agents.lines.separating_lines import SeparatingLines
from agents.peers.neighbours import Neighbours
from agents.peers.state import addressed_to
from protocol.messages import Answer, Grants, ListedBinding, Proposal, State, Vector

RADII = {1: 0.04, 2: 0.04, 3: 0.04}
HALFWAY = (1.0, 0.0, 0.05)  # m, between (0, 0) and (0.1, 0)
STILL = (0.0, 0.0)
WIDE = 1.0  # m


def robot(identity: int, *bindings: ListedBinding, at: Vector = STILL, bound: float = 0.0) -> SeparatingLines:
    lines = SeparatingLines(identity, RADII[identity], speed=0.1, period=0.05)
    hear(lines, 9, *bindings)
    lines.locate(0, at, bound)
    return lines


def hear(lines: SeparatingLines, version: int, *bindings: ListedBinding) -> None:
    lines.on_grants(Grants(4, version, 8, None, bindings), Neighbours(RADII))


def said(identity: int, tick: int, x: float, *entries: Proposal | Answer) -> State:
    proposals = tuple(each for each in entries if isinstance(each, Proposal))
    answers = tuple(each for each in entries if isinstance(each, Answer))
    return State(identity, 1, tick, (x, 0.0), 0.0, 0.0, 0.0, STILL, proposals=proposals, answers=answers)


def test_a_robot_stands_until_it_obeys_a_region_that_it_is_in() -> None:
    lines = SeparatingLines(1, 0.04, speed=0.1, period=0.05)
    lines.locate(0, STILL, 0.0)
    assert not lines.ready
    lines.on_grants(Grants(4, 9, 8, (0.5, 0.0, 0.3), ()), Neighbours(RADII))
    lines.locate(1, STILL, 0.0)
    assert (lines.ready, lines.version, lines.region) == (False, 9, 0)
    lines.locate(2, (0.4, 0.0), 0.17)  # not surely inside
    assert not lines.ready
    lines.locate(3, (0.4, 0.0), 0.15)
    assert (lines.ready, lines.region) == (True, 8)
    assert lines.region_disk is not None


def test_an_older_tick_or_one_to_another_life_is_not_taken_in() -> None:
    lines = robot(1, ListedBinding(5, 2, HALFWAY), at=(0.0, 0.0))
    hear(lines, 8)
    lines.on_grants(Grants(7, 20, 19, None, ()), Neighbours(RADII))
    assert (lines.version, lines.peers) == (9, {2})
    hear(lines, 10)
    assert (lines.version, lines.peers) == (10, set())


def test_an_obeyed_line_keeps_the_disk_on_its_side_and_an_obstacle_turns_it() -> None:
    place = ListedBinding(6, -1, (0.0, 1.0, -0.06), ((0.0, -0.1),), 0.03, True)
    lines = robot(1, ListedBinding(5, 2, HALFWAY), place, at=(0.0, 0.0))
    sides = {(round(s.nx, 6), round(s.ny, 6)): s.limit for _, s in lines.crossed(0.0, 0.0, WIDE)}
    assert sides[1.0, 0.0] == pytest.approx(0.01)
    assert sides[0.0, -1.0] == pytest.approx(0.03)  # the tangent, not the first line
    assert len(lines.obeyed_lines()) == 1  # those towards robots


def test_a_first_line_is_found_said_until_it_is_told_and_obeyed_meanwhile() -> None:
    asked = ListedBinding(5, 2, None, ((0.1, 0.0),), 0.04)
    lines = robot(1, asked)
    (first,) = lines.firsts()
    assert (first.binding, first.nx, first.ny, first.offset) == (5, 1.0, 0.0, pytest.approx(0.06))
    assert lines.crossed(0.0, 0.0, WIDE)
    hear(lines, 10, asked)
    assert lines.firsts() == (first,)
    hear(lines, 11, ListedBinding(5, 2, (first.nx, first.ny, first.offset), ((0.1, 0.0),), 0.04))
    assert lines.firsts() == ()


def test_a_line_obeyed_towards_an_earlier_life_is_the_first_one_where_no_other_fits() -> None:
    def first(nx: float, obeyed_towards: int = 2) -> list[tuple[float, float, float]]:
        earlier = ListedBinding(5, obeyed_towards, (nx, 0.0, 0.05), ((0.1, 0.0),), 0.04, True)
        lines = robot(1, earlier, bound=0.03)  # no line with the place behind it leaves that much
        hear(lines, 10, earlier, ListedBinding(9, 2, None, ((0.1, 0.0),), 0.04))
        lines.locate(1, STILL, 0.03)
        return [(each.nx, each.ny, each.offset) for each in lines.firsts()]

    assert first(1.0) == [HALFWAY]
    assert first(-1.0) == []  # the place is not behind it
    assert first(1.0, obeyed_towards=3) == []


@pytest.mark.parametrize("identity", [1, 3])
def test_a_robot_that_finds_no_room_for_a_first_line_backs_off_until_there_is(identity: int) -> None:
    lines, x = robot(identity, ListedBinding(5, 2, None, ((0.082, 0.0),), 0.043), bound=0.001), 0.0
    for tick in range(1, 9):
        vx, vy = lines.make_room(STILL)
        assert vy == 0.0
        assert vx == 0.0 if lines.firsts() else vx < 0.0
        x += 0.05 * max(vx, -0.1)
        lines.locate(tick, (x, 0.0), 0.001)
    assert lines.firsts()
    assert lines.make_room((0.02, 0.01)) == (0.02, 0.01)


def test_an_owner_obeys_what_it_proposes_at_once_and_drops_it_when_it_is_answered() -> None:
    owner = robot(1, ListedBinding(5, 2, HALFWAY))
    owner.on_state(addressed_to(1, said(2, 0, 0.1), 0.04))
    (offer,) = owner.entries((0.1, 0.0))[0]
    assert offer.binding == 5
    assert len(owner.obeyed_lines()) == 2
    owner.on_state(addressed_to(1, said(2, 1, 0.1, Answer(1, 4, offer.number, offer.number)), 0.04))
    assert len(owner.obeyed_lines()) == 2  # of another binding
    for tick in (2, 3):  # the second time it is known
        owner.on_state(addressed_to(1, said(2, tick, 0.1, Answer(1, 5, offer.number, offer.number)), 0.04))
        ((_, _, _, limit),) = owner.obeyed_lines()
        assert limit == pytest.approx(offer.offset)


def test_an_owner_whose_proposal_is_rejected_obeys_the_line_before() -> None:
    owner = robot(1, ListedBinding(5, 2, HALFWAY))
    owner.on_state(addressed_to(1, said(2, 0, 0.1), 0.04))
    (offer,) = owner.entries((0.1, 0.0))[0]
    owner.on_state(addressed_to(1, said(2, 1, 0.1, Answer(1, 5, 0, offer.number)), 0.04))
    assert owner.obeyed_lines() == ((2, *HALFWAY),)


def test_a_follower_adopts_what_fits_once_and_says_so() -> None:
    follower = robot(2, ListedBinding(5, 1, HALFWAY), at=(0.1, 0.0))
    for binding, number, offset in ((4, 9, 0.054), (5, 1, 0.055), (5, 2, 0.07), (5, 2, 0.056), (5, 1, 0.052)):
        offer = Proposal(2, binding, number, 1.0, 0.0, offset)
        follower.on_state(addressed_to(2, said(1, number, 0.0, offer), 0.04))
    assert [(answer.held, answer.seen) for answer in follower.entries(STILL)[1]] == [(1, 2)]
    ((_, nx, _, limit),) = follower.obeyed_lines()
    assert (nx, limit) == (-1.0, pytest.approx(-0.055))
    follower.on_state(addressed_to(2, said(1, 9, 0.0, Proposal(2, 5, 3, 2.0, 0.0, 0.0)), 0.04))
    assert follower.obeyed_lines()[0][1] == -1.0  # what is no line is never adopted


def test_a_larger_disk_keeps_off_everything_but_the_part_that_it_takes_up() -> None:
    part = ListedBinding(6, -3, (0.0, 1.0, -0.042), ((0.0, -0.083),), 0.04, True)
    lines = robot(1, ListedBinding(5, 2, HALFWAY), part)
    assert not lines.enlarge(0.06, -3)
    assert not lines.enlarge(0.045, 0)
    assert lines.enlarge(0.045, -3)
    limits = {peer: side.limit for peer, side in lines.crossed(0.0, 0.0, WIDE)}
    assert limits == {2: pytest.approx(0.005), -3: pytest.approx(0.003)}
    hear(lines, 10, ListedBinding(5, 2, HALFWAY))
    lines.resize(0.04)
    assert {peer: side.limit for peer, side in lines.crossed(0.0, 0.0, WIDE)} == {2: pytest.approx(0.01)}


def test_nothing_is_surely_satisfied_where_nothing_is_known() -> None:
    lines = robot(1, ListedBinding(5, 2, None, ((0.3, 0.0),), 0.04), bound=math.inf)
    assert lines.firsts() == ()
    assert lines.region == 8  # anywhere
