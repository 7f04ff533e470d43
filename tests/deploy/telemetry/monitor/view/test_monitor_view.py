"""The view: messages and presence in, plain data out."""

from __future__ import annotations

import json
from dataclasses import replace

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from deploy.telemetry.monitor import snapshot as telling
from deploy.telemetry.monitor.live import FleetView
from protocol.messages import Clock, Errand, GoalStatus, Message, PartPlace, Standing, Truth
from protocol.scenario.model import Order, Part, RobotSpec
from tests.deploy.telemetry.monitor.view.heard import SCENARIO, clock, health, rows, run_to, truth, view


def test_robots_move_with_the_truth_and_their_velocity_is_what_was_executed() -> None:
    it = view()
    run_to(it, 1, 0.0)
    run_to(it, 3, 0.1)  # one truth was dropped on the way
    frame = telling.snapshot(it, 0.1)
    assert frame["phase"] == "running"
    assert frame["tick"] == 3
    assert frame["time"] == pytest.approx(0.15)
    assert frame["samples"][-1][4][0] == [-0.1, 0.003]
    assert frame["robots"][0]["velocity"] == pytest.approx([0.0, 0.02])
    assert frame["robots"][0]["distance"] == pytest.approx(0.097)


def goal(number: int, tick: int, status: Errand = "under way", x: float = 0.2, ahead: int = 0) -> GoalStatus:
    return GoalStatus(1, tick, number, status, (x, 0.0), ahead)


def test_goals_follow_orders_and_an_older_word_changes_nothing() -> None:
    it = view()
    run_to(it, 1, 0.0)
    assert rows(it, 0.0)[1]["goal"] == (-0.1, 0.1)
    it.on_message(goal(2, 9, ahead=3), 0.0)
    it.on_message(goal(1, 8, x=-0.2), 0.0)
    it.on_message(GoalStatus(77, 9, 1, "under way", (0.0, 0.0)), 0.0)  # nobody of this run
    row = rows(it, 0.0)[1]
    assert (row["goal"], row["ahead"]) == ((0.2, 0.0), 3)
    assert row["distance"] == pytest.approx(0.3, abs=1e-4)
    assert telling.overview(it)["robots"][0]["goal"] == (0.2, 0.0)


def test_who_comes_late_is_told_where_robots_were_sent() -> None:
    it = FleetView("r")
    it.begin(SCENARIO, True, (goal(4, 90),))
    assert rows(it, 0.0)[1]["goal"] == (0.2, 0.0)


def test_lines_to_who_is_far_away_are_not_told() -> None:
    it = view()
    it.on_message(truth(1), 0.0)
    it.on_message(Truth(2, (1, 2, 3), ((-0.4, 0.0), (0.0, 0.0), (0.1, 0.0)), 0.02, 0.5), 0.0)
    it.on_message(health(1, 2), 0.0)
    it.on_message(health(3, 2), 0.0)
    assert [len(row["lines"]) for row in rows(it, 0.0).values()] == [0, 0, 1]  # type: ignore[arg-type]


def test_health_gives_rate_bound_rejections_lines_and_restarts() -> None:
    it = view()
    it.on_message(health(1, 10, published=20), 1.0)
    it.on_message(health(1, 20, published=40), 1.5)
    row = rows(it, 1.5)[1]
    assert row["rate"] == pytest.approx(20.0)  # states, each with a command
    assert (row["bound"], row["rejected"], row["restarts"]) == (0.001, 3, 0)
    assert (row["lines"], row["lines_tick"]) == (((2, 1.0, 0.0, 0.1),), 20)
    it.on_message(health(1, 30, life=3), 2.0)
    it.on_message(health(1, 21, life=1, published=99), 2.1)  # an old life, late
    assert rows(it, 2.1)[1]["restarts"] == 2
    assert rows(it, 9.0)[1]["rate"] == 0.0


def test_lives_before_a_later_scenario_are_not_restarts_of_it() -> None:
    it = view()
    it.begin(SCENARIO, True)
    it.on_message(health(1, 1, life=5), 0.0)
    assert rows(it, 0.0)[1]["restarts"] == 0
    it.on_message(health(1, 2, life=6), 0.1)
    assert rows(it, 0.1)[1]["restarts"] == 1


def test_a_clock_that_goes_back_is_another_scenario() -> None:
    it = view()
    it.on_message(clock(40), 0.0)
    assert not it.is_news(clock(40))
    assert it.is_news(clock(0))
    it.on_message(clock(40, verdict="arrived"), 0.0)
    assert not it.is_news(clock(40, verdict="arrived"))
    assert it.is_news(clock(40))


ids = st.integers(1, 5)  # some of them no robot of the scenario
number = st.floats(-10.0, 10.0)
place = st.tuples(number, number)
several = st.lists(ids).map(tuple)
downs = st.lists(st.builds(Standing, ids, st.integers(0, 3), place)).map(tuple)
heard_of = st.lists(st.tuples(ids, st.integers(0, 99))).map(tuple)
ticks = st.integers(0, 99)
messages = st.one_of(
    st.builds(Clock, ticks, st.floats(0, 9), several, downs, st.sampled_from(["", "arrived", "collision"])),
    st.builds(Truth, ticks, several, st.lists(place).map(tuple), number, number),
    st.builds(health, ids, ticks, life=st.integers(0, 3), heard=heard_of),
)
presences = st.tuples(st.one_of(st.none(), ids), st.booleans())


@pytest.mark.slow
@given(st.lists(st.one_of(messages, presences), max_size=40))
def test_whatever_is_heard_can_be_told_as_json(events: list[Message | tuple[int | None, bool]]) -> None:
    it = view(alive=False)
    for n, event in enumerate(events):
        if isinstance(event, tuple):
            it.present(*event)
        else:
            it.on_message(event, n * 0.1)
        json.loads(msgspec.json.encode(telling.snapshot(it, n * 0.1)))
    assert json.loads(msgspec.json.encode(telling.overview(it)))["scenario"] == "three"
    assert {row["id"] for row in telling.snapshot(it, 99.0)["robots"]} <= {1, 2, 3}


def test_before_the_scenario_is_known_there_is_nothing_but_the_name() -> None:
    it = FleetView("r")
    it.present(1, True)
    it.on_message(truth(1), 0.0)
    assert telling.overview(it)["scenario"] is None
    frame = telling.snapshot(it, 0.0)
    assert (frame["phase"], frame["robots"], frame["samples"]) == ("searching", [], [])
    it.begin(SCENARIO, True)
    assert rows(it, 0.0)[1]["alive"] is True


def test_who_comes_is_a_robot_like_the_others_and_who_leaves_is_none() -> None:
    guest = RobotSpec(5, 0.02, (0.0, 0.2), (0.1, 0.2))
    it = FleetView("r")
    it.begin(
        replace(SCENARIO, orders=(Order(0.1, add=guest),), parts=(Part(0.035, (0.2, 0.2), (0.2, 0.1)),)), True
    )
    it.present(9, True)
    run_to(it, 2, 0.1)
    epoch = it.epoch
    there = Truth(3, (1, 2, 3, 5), (*truth(3).positions, guest.start), 0.02, 0.5)
    it.on_message(there, 0.15)
    it.on_message(Clock(3, 0.15, (1, 2, 3, 5), (), "", parts=(PartPlace(1, carrier=5),)), 0.15)
    assert it.epoch == epoch + 1  # who shows them begins anew
    assert rows(it, 0.2)[5]["radius"] == 0.035
    assert rows(it, 0.2)[5]["distance"] == pytest.approx(0.1)
    it.on_message(Truth(4, (1, 3, 9), ((0.0, 0.0), (0.1, 0.0), (0.0, -0.2)), 0.02, 0.5), 0.2)
    assert rows(it, 0.2).keys() == {1, 3}
    assert it.strangers == {9}  # nobody said how large it is
    it.meet(replace(SCENARIO, robots=(*SCENARIO.robots, RobotSpec(9, 0.01, (0.0, -0.2), (0.0, 0.2)))))
    assert it.strangers == set()
    it.on_message(Truth(5, (1, 3, 9), ((0.0, 0.0), (0.1, 0.0), (0.0, -0.1)), 0.02, 0.5), 0.25)
    assert rows(it, 0.3)[9]["distance"] == pytest.approx(0.3)
