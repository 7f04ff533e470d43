"""Initial lines that are looked at together, only when somebody may come near, are the same lines."""

from __future__ import annotations

import math
from random import Random

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from agents.lines.boundary import RoundBoundary
from agents.lines.initial_lines import InitialLines
from agents.lines.placement import initial_line
from agents.lines.safe_velocity import safe_velocity
from agents.lines.separating_lines import SeparatingLines
from agents.peers.far import FarPicture, places_of
from protocol.messages import Member, Summary
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


def test_far_lines_are_not_looked_at_one_by_one() -> None:
    starts, radii = fleet(1, 60)
    lines = ledger(1, starts, radii, 0.1)
    lines.locate(0, starts[1], 0.0)
    lines.half_planes()
    assert len(lines.obeyed_lines()) < 20
