"""Who is near whom is mutual, follows from what was sensed, and is said early enough to be heard."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.peers.far import FarPicture, places_of
from protocol.crowd.interest import LEAD, inner, outer, period
from protocol.errors import MessageError
from protocol.messages import Command, Sense, Summary, Vector
from protocol.scenario.model import Network, Scenario
from tests.world.driving import joined, scenario
from world.coordinator.crowd.interest import Interest, runs

places = st.lists(st.tuples(st.floats(-0.25, 0.25), st.floats(-0.25, 0.25)), min_size=4, max_size=4)
RADIUS = 0.01


def four(reach: float = 0.05) -> Scenario:
    robots = [((0.1 * n, 0.0), (0.1 * n, 0.1)) for n in range(-2, 2)]
    return scenario(*robots, radius=RADIUS, network=Network("near", reach))


def sensed(at: list[Vector]) -> dict[int, Sense]:
    return {robot: Sense(place, 0, 0.0, (0.0, 0.0)) for robot, place in enumerate(at, 1)}


def nowhere(robot: int) -> Vector | None:  # noqa: ARG001  # sent by nobody
    return None


@given(st.lists(places, min_size=1, max_size=4))
def test_near_is_mutual_and_has_hysteresis(path: list[list[Vector]]) -> None:
    setting, tick = four(), 0
    interest = Interest(setting)
    before: set[tuple[int, int]] = set()
    for at in path:
        interest.open(tick, setting, sensed(at), nowhere)
        told = {robot: set(interest.tell(robot, 1, tick) or ()) for robot in setting.ids}
        near = {(one, other) for one in told for other in told[one]}
        for one in setting.ids:
            for other in setting.ids:
                gap = math.dist(at[one - 1], at[other - 1]) - 2.0 * RADIUS
                limit = outer(setting) if (one, other) in before else inner(setting)
                if one != other and abs(gap - limit) > 1e-9:
                    assert ((one, other) in near) == (gap < limit)
        assert {(other, one) for one, other in near} == near
        before = near
        tick += period(setting)


def test_nobody_is_awaited_before_it_can_be_heard() -> None:
    setting = four(1.0)
    interest = Interest(setting)
    everybody, heard = frozenset(setting.ids), []
    for tick in range(LEAD + 1):
        interest.open(tick, setting, {}, nowhere)
        heard.append(interest.heard(1, 1, tick, everybody) or interest.near(1))
        interest.tell(1, 1, tick)
    assert heard == [(1,)] * LEAD + [setting.ids]


def test_a_later_life_is_told_at_once_and_awaits_nobody_meanwhile() -> None:
    setting = four(1.0)
    interest = Interest(setting)
    everybody = frozenset(setting.ids)
    for tick in range(period(setting) - 1):
        interest.open(tick, setting, {}, nowhere)
        interest.heard(1, 1, tick, everybody)
        interest.tell(1, 1, tick)
    tick = period(setting) - 1
    interest.open(tick, setting, {}, nowhere)
    assert interest.heard(1, 2, tick, everybody) == (1,)
    assert interest.tell(1, 2, tick) == (2, 3, 4)
    assert (interest.heard(1, 2, tick, everybody), interest.near(1)) == (None, (1,))


def test_the_summary_says_where_everybody_was_sensed() -> None:
    setting = four()
    interest = Interest(setting)
    at = [(0.01 * n, 0.02) for n in range(4)]
    interest.open(0, setting, sensed(at), nowhere)
    for tick in range(1, period(setting)):
        interest.open(tick, setting, sensed([(0.2, 0.2)] * 4), nowhere)
    assert interest.summary is not None
    assert interest.summary.tick == 0
    assert interest.summary.robots == runs((1, 2, 3, 4))
    assert np.allclose(np.frombuffer(interest.summary.positions, "<f4").reshape(-1, 2), at)
    away = [math.dist(place, spec.goal) ** 2 for place, spec in zip(at, setting.robots, strict=True)]
    assert np.allclose(np.frombuffer(interest.summary.gammas, "<f4"), away)


def test_who_comes_later_has_a_place_and_who_was_near_remains_so() -> None:
    setting = four(0.06)
    interest = Interest(setting)
    interest.open(0, setting, sensed([(0.0, 0.0), (0.07, 0.0), (0.2, 0.2), (-0.2, 0.2)]), nowhere)
    fewer = replace(setting, robots=setting.robots[:3])
    moved = [(0.0, 0.0), (0.1, 0.0), (0.2, 0.2)]
    interest.open(1, fewer, sensed(moved), nowhere)
    assert interest.tell(2, 1, 1) == (1,)


def test_a_tick_names_only_those_who_are_heard() -> None:
    world = joined(four())
    assert {told.active for told in world.open_tick().values()} == {(robot,) for robot in world.scenario.ids}
    assert world.coordinator.active == world.scenario.ids


def test_a_tick_says_nothing_of_those_who_are_heard_until_one_of_them_takes_no_part() -> None:
    world = joined(four(1.0))
    ids = world.scenario.ids
    for _ in range(LEAD + 1):
        told = world.open_tick()
        for robot in ids:
            assert world.accept(Command(robot, 1, world.tick, (0.0, 0.0)))
        world.close_tick()
    told = world.open_tick()
    assert {each.active for each in told.values()} == {None}
    assert world.coordinator.lost(4)
    told = world.open_tick()
    assert [told[robot].active for robot in ids[:3]] == [ids[:3]] * 3


@given(st.sets(st.integers(1, 12), min_size=1))
def test_runs_stand_for_the_ids_that_they_are_made_of(ids: set[int]) -> None:
    flat = np.zeros(len(ids), dtype="<f4").tobytes()
    assert places_of(Summary(0, runs(sorted(ids)), 2 * flat, flat, flat)).robots.tolist() == sorted(ids)


@pytest.mark.parametrize("told", [(2, 2, 3, 1), (4, 1, 2, 2), (1, 2**32 - 1), (1, 4), (1, 1)])
def test_runs_that_cannot_be_are_refused(told: tuple[int, ...]) -> None:
    made = np.array(told, dtype="<u4").tobytes()
    with pytest.raises(MessageError):
        places_of(Summary(0, made, bytes(24), bytes(12), bytes(12)))


def test_a_summary_has_the_slices_as_last_commanded_and_else_the_attraction() -> None:
    setting = four()
    interest = Interest(setting)
    interest.accept(Command(3, 1, 4, (0.0, 0.0), slice=0.75))
    interest.accept(Command(3, 1, 5, (0.0, 0.0)))  # says nothing of it, so that it stays
    interest.open(0, setting, {}, nowhere)
    assert interest.summary is not None
    gammas = np.frombuffer(interest.summary.gammas, dtype="<f4")
    attraction = (2.0 * np.sqrt(gammas)).tolist()
    slices = np.frombuffer(interest.summary.slices, dtype="<f4").tolist()
    assert slices == pytest.approx([*attraction[:2], 0.75, attraction[3]])


SIGNALLING = np.full(1, 0x7FA00001, "<u4").tobytes()  # NaN of which a conversion would warn


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    "slices",
    [bytes(8), np.full(1, -1.0, "<f4").tobytes(), np.full(1, np.nan, "<f4").tobytes(), SIGNALLING],
)
def test_slices_that_are_no_norms_are_refused(slices: bytes) -> None:
    with pytest.raises(MessageError):
        places_of(Summary(0, runs([1]), bytes(8), bytes(4), slices))


def test_what_several_robots_read_is_read_once_and_nobody_can_change_it() -> None:
    flat = np.arange(3, dtype="<f4").tobytes()
    summary = Summary(4, runs([1, 2, 7]), flat + flat, flat, flat)
    mine, theirs = (
        FarPicture(places_of(summary), {1: 0.1, 2: 0.2}),
        FarPicture(places_of(summary), {2: 0.3, 7: 0.4}),
    )
    assert mine.said is theirs.said
    for array in (mine.said.x, mine.said.y, mine.said.robots):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 5
    fields = [picture.field((9.0, 9.0), 0.1, ()) for picture in (mine, theirs)]
    assert fields[0].log_x != fields[1].log_x  # the radii are each robot's own
    assert [picture.place(7) for picture in (mine, theirs)] == [(1.0, 2.0)] * 2
