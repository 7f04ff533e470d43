"""What one robot obeys of what the ledger says, and what it asks of the ledger and its peers."""

import math

import pytest

from agents.lines.separating_lines import SeparatingLines
from agents.peers.neighbours import Neighbours
from agents.peers.state import addressed_to
from protocol.bodies.sweep import Sweep
from protocol.line import ROUNDING
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


def hear(lines: SeparatingLines, version: int, *bindings: ListedBinding, region: int = 8) -> None:
    lines.on_grants(Grants(4, version, region, None, bindings), Neighbours(RADII))


def said(identity: int, tick: int, x: float, *entries: Proposal | Answer) -> State:
    proposals = tuple(each for each in entries if isinstance(each, Proposal))
    answers = tuple(each for each in entries if isinstance(each, Answer))
    return State(identity, 1, tick, (x, 0.0), 0.0, 0.0, 0.0, STILL, proposals=proposals, answers=answers)


def test_a_robot_stands_until_it_obeys_a_region_that_it_is_in() -> None:
    lines = SeparatingLines(1, 0.04, speed=0.1, period=0.05)
    lines.locate(0, STILL, 0.0)
    assert (lines.ready, lines.version, lines.region, lines.region_disk) == (False, 0, 0, None)
    assert (lines.entries(STILL), lines.enlarge(0.041, 0)) == (((), ()), False)
    hear(lines, 8, region=4)  # that of an earlier life
    lines.locate(0, STILL, 0.0)
    assert (lines.ready, lines.version) == (False, 8)
    lines.on_grants(Grants(4, 9, 8, (0.5, 0.0, 0.3), ()), Neighbours(RADII))
    lines.locate(1, STILL, 0.0)
    assert (lines.ready, lines.version, lines.region) == (False, 9, 0)
    assert not lines.enlarge(0.041, 0)
    lines.locate(2, (0.4, 0.0), 0.17)  # not surely inside
    assert not lines.ready
    lines.locate(3, (0.4, 0.0), 0.15)
    assert (lines.ready, lines.region) == (True, 8)
    assert lines.region_disk is not None
    assert not lines.enlarge(0.051, 0)
    assert robot(1).region_disk is None  # as its region is the plane


def test_an_older_tick_or_one_to_another_life_is_not_taken_in() -> None:
    lines = robot(1, ListedBinding(5, 2, HALFWAY), at=(0.0, 0.0))
    hear(lines, 8)
    hear(lines, 9)
    lines.on_grants(Grants(7, 20, 19, None, ()), Neighbours(RADII))
    assert (lines.version, lines.peers) == (9, {2})
    hear(lines, 10)
    assert (lines.version, lines.peers) == (10, set())


def test_an_obeyed_line_keeps_the_disk_on_its_side_and_an_obstacle_turns_it() -> None:
    place = ListedBinding(6, -1, (0.0, 1.0, -0.06), ((0.0, -0.1),), 0.03, True)
    lines = robot(1, ListedBinding(5, 2, HALFWAY), place, at=(0.0, 0.0))
    assert lines.peers == {2}
    sides = {(round(s.nx, 6), round(s.ny, 6)): s.limit for _, s in lines.crossed(0.0, 0.0, WIDE)}
    assert sides[1.0, 0.0] == pytest.approx(0.01)
    assert sides[0.0, -1.0] == pytest.approx(0.03)  # the tangent, not the first line
    assert len(lines.obeyed_lines()) == 1  # those towards robots


def test_a_first_line_is_found_said_until_it_is_told_and_obeyed_meanwhile() -> None:
    asked = ListedBinding(5, 2, None, ((0.1, 0.0),), 0.04)
    lines = robot(1, asked, at=(-0.02, 0.0))
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


@pytest.mark.parametrize("adopted", [True, False])
def test_an_owner_obeys_what_it_proposes_at_once_and_what_is_held_when_it_is_answered(adopted: bool) -> None:
    owner = robot(1, ListedBinding(5, 2, HALFWAY))
    owner.on_state(addressed_to(1, said(2, 0, 0.1), 0.04))
    (offer,) = owner.entries((0.1, 0.0))[0]
    assert offer.binding == 5
    held = offer.number if adopted else 0
    for answer in (Answer(1, 4, held, offer.number), Answer(1, 5, held, offer.number + 1)):
        owner.on_state(addressed_to(1, said(2, 1, 0.1, answer), 0.04))
        assert len(owner.obeyed_lines()) == 2  # of another binding, or to what it has not proposed
    for tick in (2, 3):  # the second time it is known
        owner.on_state(addressed_to(1, said(2, tick, 0.1, Answer(1, 5, held, offer.number)), 0.04))
        assert owner.obeyed_lines() == ((2, 1.0, 0.0, pytest.approx(offer.offset if adopted else 0.05)),)


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
    follower.on_state(addressed_to(2, said(3, 9, 0.0), 0.04))  # to which it is not bound
    still = robot(2, ListedBinding(5, 1, HALFWAY, (STILL,), 0.04, True), at=(0.1, 0.0))
    still.on_state(addressed_to(2, said(1, 9, 0.0, Proposal(2, 5, 1, 1.0, 0.0, 0.05)), 0.04))
    assert still.entries(STILL) == ((), ())


def test_a_follower_that_has_become_larger_rejects_what_would_have_fitted_before() -> None:
    follower = robot(2, ListedBinding(5, 1, HALFWAY), at=(0.1, 0.0))
    assert follower.enlarge(0.045, 0)
    follower.on_state(addressed_to(2, said(1, 1, 0.0, Proposal(2, 5, 1, 1.0, 0.0, 0.057)), 0.04))
    assert follower.obeyed_lines() == ((1, -1.0, 0.0, pytest.approx(-0.05)),)


@pytest.mark.parametrize("swept", [None, Sweep([0.0, 0.01], [0.0, 0.0], [0.001, 0.001])])
def test_an_owner_that_stands_leaves_the_other_all_but_what_it_covers_or_wants(swept: Sweep | None) -> None:
    owner = robot(1, ListedBinding(5, 2, (1.0, 0.0, 0.1)))
    owner.kernel.region, owner.wanted = None, 0.05
    owner.on_state(addressed_to(1, said(2, 0, 0.15), 0.04))
    owner.locate(1, STILL, 0.002, None, swept)
    owner.kernel.region = None
    (offer,) = owner.entries((0.1, 0.0))[0]
    assert offer.offset == pytest.approx(0.05 + 0.002 + (0.011 if swept else 0.0), abs=1e-6)


@pytest.mark.parametrize(("slack", "found"), [(0.0199, True), (0.0241, False)])
@pytest.mark.parametrize("bound", [0.0, 0.002])
def test_half_planes_within_reach_keep_the_whole_set_in(slack: float, found: bool, bound: float) -> None:
    lines = SeparatingLines(1, 0.04, speed=0.1, period=0.05, reach=0.01)
    hear(lines, 9, ListedBinding(5, 2, (0.6, 0.8, 0.05)))
    along = 0.01 - slack
    lines.locate(0, (0.6 * along - 0.8 * 0.03, 0.8 * along + 0.6 * 0.03), bound)
    sides = [(side.nx, side.ny, side.limit) for side in lines.half_planes()]
    limit = pytest.approx(0.01 - bound - 2.0 * ROUNDING, abs=1e-12)
    assert sides == ([(0.6, 0.8, limit)] if found else [])


def test_a_larger_disk_keeps_off_everything_but_the_part_that_it_takes_up() -> None:
    part = ListedBinding(6, -3, (0.0, 1.0, -0.042), ((0.0, -0.083),), 0.04, True)
    lines = robot(1, ListedBinding(5, 2, HALFWAY), part)
    assert not lines.enlarge(0.06, -3)
    assert not lines.enlarge(0.045, 0)
    assert lines.enlarge(0.045, -3)
    limits = {peer: side.limit for peer, side in lines.crossed(0.0, 0.0, WIDE)}
    assert limits == {2: pytest.approx(0.005), -3: pytest.approx(0.003)}
    lines.on_grants(
        Grants(4, 10, 9, (0.0, 0.0, 0.0449), (ListedBinding(5, 2, HALFWAY), part)), Neighbours(RADII)
    )
    lines.locate(1, STILL, 0.0)
    assert lines.region == 8  # the next is too small
    hear(lines, 11, ListedBinding(5, 2, HALFWAY))
    lines.resize(0.04)
    assert {peer: side.limit for peer, side in lines.crossed(0.0, 0.0, WIDE)} == {2: pytest.approx(0.01)}


def test_nothing_is_surely_satisfied_where_nothing_is_known() -> None:
    lines = robot(1, ListedBinding(5, 2, None, ((0.3, 0.0),), 0.04), bound=math.inf)
    assert lines.firsts() == ()
    assert lines.region == 8  # anywhere
