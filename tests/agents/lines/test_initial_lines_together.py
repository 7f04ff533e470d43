"""Lines that are looked at together, only when somebody may come near, are the same lines."""

from __future__ import annotations

import math
from random import Random

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from agents.lines.boundary import RoundBoundary
from agents.lines.initial_lines import InitialLines
from agents.lines.line import ROUNDING, HalfPlane, Line
from agents.lines.placement import initial_line
from agents.lines.safe_velocity import safe_velocity
from agents.lines.separating_lines import SeparatingLines
from agents.peers.far import FarPicture, places_of
from agents.peers.state import PeerState
from protocol.messages import Answer, Member, Proposal, Summary
from world.coordinator.crowd.interest import runs

SPEED, PERIOD, ROOM = 0.1, 0.1, 3.0
Vector = tuple[float, float]


def fleet(seed: int, count: int) -> tuple[dict[int, Vector], dict[int, float]]:
    """Starts and radii (m) of disks that are apart."""
    random = Random(seed)
    starts: dict[int, Vector] = {}
    radii: dict[int, float] = {}
    while len(starts) < count:
        radius, place = random.uniform(0.01, 0.06), (random.uniform(-2, 2), random.uniform(-2, 2))
        if all(math.dist(place, starts[peer]) > radius + radii[peer] + 1e-4 for peer in starts):
            starts[len(starts) + 1], radii[len(radii) + 1] = place, radius
    return starts, radii


def ledger(
    robot: int, starts: dict[int, Vector], radii: dict[int, float], urgent: float | None
) -> SeparatingLines:
    members = {peer: Member(peer, 1, "live", radii[peer], founding=1) for peer in starts}
    return SeparatingLines(
        robot, 1, radii, speed=SPEED, period=PERIOD, members=members, starts=starts, urgent=urgent
    )


@given(st.integers(0, 2**32), st.integers(2, 60), st.floats(0.0, 3.0))
def test_every_line_within_reach_is_found(seed: int, count: int, reach: float) -> None:
    starts, radii = fleet(seed, count)
    robot, random = 1 + seed % count, Random(seed)
    x, y = random.uniform(-2, 2), random.uniform(-2, 2)
    found = InitialLines(robot, starts, radii).within(x, y, reach)
    for peer in starts.keys() - {robot}:
        line = initial_line(robot, peer, starts, radii)
        assert line is not None
        slack = line.side(radii[robot], robot < peer).slack(x, y)
        assert (peer in found) == (slack < reach) or abs(slack - reach) < 1e-5


@given(st.integers(0, 2**32), st.integers(2, 40), st.floats(0.0, 3.0))
def test_every_line_that_a_peer_may_reach_is_found_by_its_owner(seed: int, count: int, reach: float) -> None:
    starts, radii = fleet(seed, count)
    robot, random = 1 + seed % count, Random(seed)
    flat = np.array([random.uniform(-2, 2) for _ in range(2 * count)], dtype="<f4").reshape(-1, 2)
    places = dict(zip(sorted(starts), map(tuple, flat.tolist()), strict=True))
    nothing = np.zeros(count, dtype="<f4").tobytes()
    summary = Summary(3, runs(sorted(starts)), flat.tobytes(), nothing, nothing)
    picture = FarPicture(places_of(summary), radii)
    assert {peer: picture.place(peer) for peer in starts} == places
    found = InitialLines(robot, starts, radii).reached(picture, reach)
    assert min(found, default=robot + 1) > robot
    for peer in range(robot + 1, count + 1):
        line = initial_line(robot, peer, starts, radii)
        assert line is not None
        slack = line.side(radii[peer], owner=False).slack(*places[peer])
        assert (peer in found) == (slack < reach) or abs(slack - reach) < 1e-5


@given(st.integers(0, 2**32), st.integers(2, 40), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_who_may_reach_a_line_is_found_whether_all_were_looked_at_or_some(
    seed: int, count: int, reach: float, ahead: float
) -> None:
    """One summary after another, also where robots leap, come and go."""
    starts, radii = fleet(seed, count)
    robot, random = 1 + seed % count, Random(seed)
    watching, places = InitialLines(robot, starts, radii, ahead), starts
    for tick in range(20):
        far = random.choice((0.02, 0.02, 0.02, 0.5))
        places = {
            peer: (x + random.uniform(-far, far), y + random.uniform(-far, far))
            for peer, (x, y) in places.items()
        }
        there = sorted(places if random.random() < 0.8 else random.sample(sorted(places), count - 1))
        flat = np.array([places[peer] for peer in there], dtype="<f4").reshape(-1)
        nothing = np.zeros(len(there), dtype="<f4").tobytes()
        picture = FarPicture(places_of(Summary(tick, runs(there), flat.tobytes(), nothing, nothing)), radii)
        looking = InitialLines(robot, starts, radii)
        assert watching.reached(picture, reach) == looking.reached(picture, reach)


@given(st.integers(0, 2**32), st.integers(2, 40), st.floats(0.0, 3.0))
def test_who_has_left_is_found_no_more_and_all_others_are(seed: int, count: int, reach: float) -> None:
    starts, radii = fleet(seed, count)
    robot, random = 1 + seed % count, Random(seed)
    x, y = random.uniform(-2, 2), random.uniform(-2, 2)
    flat = np.array([random.uniform(-2, 2) for _ in range(2 * count)], dtype="<f4")
    nothing = np.zeros(count, dtype="<f4").tobytes()
    picture = FarPicture(places_of(Summary(3, runs(sorted(starts)), flat.tobytes(), nothing, nothing)), radii)
    lines = InitialLines(robot, starts, radii)
    before = lines.within(x, y, reach), lines.reached(picture, reach)
    left = {peer for peer in starts if random.random() < 0.5}
    for peer in [*left, count + 1]:  # of whom there never was a line, too
        lines.leave(peer)
    after = lines.within(x, y, reach), lines.reached(picture, reach)
    assert after == tuple([peer for peer in found if peer not in left] for found in before)


@given(st.integers(0, 2**32), st.integers(2, 40), st.floats(0.0, 0.01))
def test_who_skips_lines_drives_as_who_looks_at_all(seed: int, count: int, bound: float) -> None:
    """Bit for bit, wherever the robot goes: the same half-planes in the same order."""
    starts, radii = fleet(seed, count)
    robot, random = 1 + seed % count, Random(seed)
    every, some = (ledger(robot, starts, radii, urgent) for urgent in (None, 0.2))
    boundary = RoundBoundary(ROOM)
    x, y = starts[robot]
    angle = random.uniform(0.0, math.tau)
    for tick in range(60):
        angle += random.uniform(-0.3, 0.3)
        wish = (SPEED * math.cos(angle), SPEED * math.sin(angle))
        chosen = []
        for lines in (every, some):
            lines.locate(tick, (x, y), bound)
            assert lines.ready
            sides = lines.half_planes()
            chosen.append(safe_velocity(wish, (x, y), sides, boundary=boundary, speed=SPEED, period=PERIOD))
        assert chosen[0] == chosen[1]
        x, y = x + chosen[0][0] * PERIOD, y + chosen[0][1] * PERIOD
    assert some.obeyed_lines() == tuple(
        line for line in every.obeyed_lines() if line[0] in {each[0] for each in some.obeyed_lines()}
    )


@given(st.integers(0, 2**32), st.integers(2, 40), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_a_line_that_was_put_to_rest_is_found_when_either_may_reach_it(
    seed: int, count: int, reach: float, ahead: float
) -> None:
    """Wherever the lines lie, and whenever they come to rest: as if all were looked at in every place."""
    starts, radii = fleet(seed, count)
    robot, random = 1 + seed % count, Random(seed)
    lines = InitialLines(robot, starts, radii, ahead)
    for peer in starts:
        lines.leave(peer)
    resting: dict[int, tuple[HalfPlane, float]] = {}
    x, y = starts[robot]
    places = dict(starts)
    for tick in range(20):
        x, y = x + random.uniform(-0.05, 0.05), y + random.uniform(-0.05, 0.05)
        places = {
            peer: (px + random.uniform(-0.05, 0.05), py + random.uniform(-0.05, 0.05))
            for peer, (px, py) in places.items()
        }
        flat = np.array([places[peer] for peer in sorted(places)], dtype="<f4")
        nothing = np.zeros(count, dtype="<f4").tobytes()
        said = places_of(Summary(tick, runs(sorted(places)), flat.tobytes(), nothing, nothing))
        near = {peer for peer, (side, _) in resting.items() if side.slack(x, y) < reach - 1e-5}
        found = lines.approached(x, y, reach)
        assert near <= set(found)
        near = {
            peer
            for peer, (side, theirs) in resting.items()
            if peer > robot and peer not in found
            if _beyond(side, theirs, said.place(peer)) < reach - 1e-5
        }
        reached = lines.reached(FarPicture(said, radii), reach)
        assert near <= set(reached) | set(found)
        for peer in {*found, *reached}:
            lines.leave(peer)
            resting.pop(peer, None)
        for peer in starts.keys() - resting.keys() - {robot}:
            angle = random.uniform(0.0, math.tau)
            side = HalfPlane(math.cos(angle), math.sin(angle), random.uniform(-1.0, 3.0))
            theirs = random.uniform(-3.0, 1.0)
            if lines.rest(peer, side, theirs):
                resting[peer] = side, theirs
    assert not lines.rest(robot, HalfPlane(1.0, 0.0, 9.0), -9.0)
    assert not lines.rest(count + 1, HalfPlane(1.0, 0.0, 9.0), -9.0)


def _beyond(side: HalfPlane, theirs: float, place: Vector | None) -> float:
    """How far a place is from where a peer's centre has to stay, m."""
    assert place is not None
    return side.nx * place[0] + side.ny * place[1] - theirs


def _offer(random: Random, lines: SeparatingLines, peer: int, tick: int, keeps: dict[int, Line]) -> PeerState:
    """A State of a near peer, which offers another line if it owns the common one; `keeps` of what this robot
    obeys then."""
    angle, proposals = random.uniform(0.0, math.tau), ()
    own = lines._own
    if peer < lines._robot:
        nx, ny = math.cos(angle), math.sin(angle)
        line = Line(nx, ny, nx * own.x + ny * own.y - lines._radius - random.uniform(0.001, 1.0))
        keeps[peer] = line
        proposals = (Proposal(lines._robot, 1, tick + 1, line.nx, line.ny, line.offset),)
    return PeerState(peer, 1, tick, True, 5.0, 5.0, *[0.0] * 5, proposals=proposals)


@given(st.integers(0, 2**32))
def test_a_robot_that_roams_keeps_to_all_lines_and_looks_at_few(seed: int) -> None:
    """Also to those that were agreed on later and left behind."""
    starts, radii = fleet(seed, 60)
    robot, random, reach = 30, Random(seed), SPEED * PERIOD
    lines = ledger(robot, starts, radii, 0.02)
    keeps: dict[int, Line] = {}
    for peer in starts.keys() - {robot}:
        line = initial_line(robot, peer, starts, radii)
        assert line is not None
        keeps[peer] = line
    x, y = starts[robot]
    fewest = len(starts)
    for tick in range(400):
        x, y = x + random.uniform(-reach, reach), y + random.uniform(-reach, reach)
        if tick % 100 == 99:  # only lines matter here: nothing keeps this robot from being elsewhere at once
            x, y = random.uniform(-2.0, 2.0), random.uniform(-2.0, 2.0)
        lines.locate(tick, (x, y), 0.0)
        if tick % 5 == 0:
            near = random.sample(sorted(starts.keys() - {robot}), 3)
            lines.attend(sorted(near))
            for peer in near:
                offer = _offer(random, lines, peer, tick, keeps)
                lines.on_state(offer)
        expected = []
        for peer in sorted(keeps):
            side = keeps[peer].side(radii[robot], robot < peer)
            if side.slack(x, y) < 2.0 * ROUNDING + 2.0 * reach:
                expected.append((side.nx, side.ny, side.limit - 2.0 * ROUNDING))
        assert [(each.nx, each.ny, each.limit) for each in lines.half_planes()] == expected
        lines.letters()
        fewest = min(fewest, sum(not pair.rests for pair in lines._pairs.values()))
    assert len(lines.obeyed_lines()) > 40
    assert fewest < 20


def test_far_lines_are_not_looked_at_one_by_one() -> None:
    starts, radii = fleet(1, 60)
    lines = ledger(1, starts, radii, 0.1)
    lines.locate(0, starts[1], 0.0)
    lines.half_planes()
    assert len(lines.obeyed_lines()) < 20


@given(st.integers(0, 2**32), st.floats(0.005, 0.2))
def test_a_disk_that_grows_keeps_to_lines_it_has_not_looked_at(seed: int, growth: float) -> None:
    """The initial ones were computed for the disk that it was at the start."""
    starts, radii = fleet(seed, 40)
    robot, random, reach = 20, Random(seed), SPEED * PERIOD
    lines = ledger(robot, starts, radii, 0.02)
    everything = ledger(robot, starts, radii, None)
    x, y = starts[robot]
    angle = random.uniform(0.0, math.tau)
    large = radii[robot] + growth
    for tick in range(200):
        for each in (lines, everything):
            each.locate(tick, (x, y), 0.0)
        if lines._radius < large:
            assert lines.has_room(large) == everything.has_room(large)
            if lines.has_room(large):
                lines.resize(large)
                everything.resize(large)
        kept = {(side.nx, side.ny, side.limit) for side in lines.half_planes()}
        assert {(side.nx, side.ny, side.limit) for side in everything.half_planes()} <= kept
        angle += random.uniform(-0.3, 0.3)  # far enough to look again as the larger disk
        x, y = x + reach * math.cos(angle), y + reach * math.sin(angle)


def test_a_line_does_not_rest_while_another_is_about_to_be_offered() -> None:
    """The peer has said that it lives: the next letter offers a line, which is obeyed from then on."""
    starts, radii = {1: (0.0, 0.0), 2: (3.0, 0.0)}, {1: 0.05, 2: 0.05}
    lines = ledger(1, starts, radii, 0.5)
    places = np.array([0.0, 0.0, 4.0, 3.0], dtype="<f4").tobytes()
    nothing = np.zeros(2, dtype="<f4").tobytes()
    lines.locate(0, (1.1, 0.0), 0.0)
    lines.survey(FarPicture(places_of(Summary(0, runs([1, 2]), places, nothing, nothing)), radii))
    assert lines.letters() == ((), (Answer(2, 1, 0, 0),))
    lines.locate(1, (1.1, 0.7), 0.0)
    lines.on_letter(PeerState(2, 1, 1, False, *[0.0] * 7, answers=(Answer(1, 1, 0, 0),), is_letter=True))
    assert lines.letters() == ((), ())
    assert lines.half_planes() == []  # looked no farther than it may go
    lines.attend(())
    (offer,), _ = lines.letters()
    y = (offer.offset - radii[1] - 0.001 + 2.0 * offer.nx) / offer.ny
    lines.locate(2, (-2.0, y), 0.0)  # near that one only
    assert [(side.nx, side.ny) for side in lines.half_planes()] == [(offer.nx, offer.ny)]
