"""Pairs that sleep are those that nobody has to look at."""

import math
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.lines.placement import initial_line
from agents.lines.robot_pair import RobotPair
from agents.lines.watch import Watch
from protocol.messages import Member

OWN, RADIUS = 5, 0.05
AHEAD = 0.2


def watch_of(starts: dict[int, tuple[float, float]]) -> Watch:
    watch = Watch(AHEAD)
    for peer in starts:
        if peer != OWN:
            line = initial_line(OWN, peer, starts, dict.fromkeys(starts, RADIUS))
            pair = RobotPair(
                peer,
                1,
                owns=peer > OWN,
                own_radius=RADIUS,
                radius=RADIUS,
                initial=line,
                peer_incarnation=1,
                woken=watch.woken,
            )
            watch.add(pair)
    return watch


def obeyed(pairs: list[RobotPair], x: float, y: float, reach: float) -> list[tuple[int, float, float]]:
    sides = [(pair.peer, side) for pair in pairs for side in pair.half_planes]
    return [(peer, side.nx, side.limit) for peer, side in sides if side.slack(x, y) < reach]


@given(st.integers(0, 2**32), st.integers(2, 12), st.sampled_from([0.0, 1.0, 9e4]))
def test_nothing_that_is_near_and_nobody_who_is_not_ready_sleeps(seed: int, robots: int, away: float) -> None:
    draw = random.Random(seed)
    starts = {
        OWN + n - robots // 2: (away + 3 * math.cos(2.4 * n), 3 * math.sin(2.4 * n) + n)
        for n in range(robots)
    }
    watch = watch_of(starts)
    watch.sort()
    assert [pair.peer for pair in watch.each] == sorted(set(starts) - {OWN})
    x, y = starts[OWN]
    for _ in range(60):
        x, y = x + draw.uniform(-0.1, 0.1), y + draw.uniform(-0.1, 0.1)
        event, pair = draw.randrange(10), draw.choice(watch.each)
        if event == 0:
            pair.resize(draw.choice((RADIUS, 2 * RADIUS)))
        elif event == 1:
            pair.on_member(Member(pair.peer, 1, "standing", RADIUS, (x, y + 1.0), 0.0))
        elif event == 2:
            pair.on_member(Member(pair.peer, 2, "live", RADIUS))
        reach = draw.choice((0.0, 0.05, 0.3))
        assert all(each.ready for each in watch.each if each not in watch.awake())
        near = watch.near(x, y, reach)
        assert obeyed(near, x, y, reach) == obeyed(watch.each, x, y, reach)
        assert near == [each for each in watch.each if not each.asleep]


def test_most_sleep_while_the_robot_goes_no_farther_than_they_allow() -> None:
    starts = {OWN: (0.0, 0.0), 6: (0.5, 0.0), 7: (10.0, 0.0), 8: (0.0, 10.0)}
    watch = watch_of(starts)
    assert len(watch.awake()) == 3
    for x in (0.0, 0.1, 0.19):
        assert [pair.peer for pair in watch.near(x, 0.0, 0.1)] == [6]
    assert [pair.peer for pair in watch.near(4.7, 0.0, 0.1)] == [6, 7]


@pytest.mark.parametrize("reach", [0.1, math.inf])
def test_who_does_not_know_where_it_is_looks_at_all(reach: float) -> None:
    watch = watch_of({OWN: (0.0, 0.0), 6: (9.0, 0.0)})
    assert len(watch.near(0.0, 0.0, math.inf)) == 1
    assert len(watch.near(0.0, 0.0, reach)) == (reach == math.inf)
