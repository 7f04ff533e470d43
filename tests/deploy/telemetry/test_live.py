"""A view of a run: messages and presence in, statuses and other plain data out."""

import json
from dataclasses import replace

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from deploy.telemetry.live import FleetView
from deploy.telemetry.monitor import snapshot as telling
from deploy.telemetry.monitor.terminal import table
from protocol.messages import Clock, GoalStatus, Health, Message, OrderStatus, PartPlace, Standing, Truth
from protocol.operations import Steering
from protocol.scenario.model import Order, Part, RobotSpec, Scenario, Time
from tests.deploy.printed import printed

SCENARIO = Scenario(
    tuple(RobotSpec(i, 0.03, (0.1 * i - 0.2, 0.0), (0.1 * i - 0.2, 0.1)) for i in (1, 2, 3)),
    name="three",
    time=Time(step=0.05),
)


def view(*, alive: bool = True, lockstep: bool = True) -> FleetView:
    it = FleetView("r")
    it.begin(SCENARIO, lockstep)
    for robot in (None, 1, 2, 3):
        it.on_token(robot, alive)
    return it


def clock(
    tick: int, active: tuple[int, ...] = (1, 2, 3), verdict: str = "", down: tuple[Standing, ...] = ()
) -> Clock:
    return Clock(tick, tick * 0.05, active, down, verdict)


def truth(tick: int, y: float = 0.0, clearance: float = 0.02) -> Truth:
    return Truth(tick, (1, 2, 3), tuple((0.1 * i - 0.2, y) for i in (1, 2, 3)), clearance, 0.5)


def health(
    robot: int, tick: int, *, life: int = 1, published: int = 0, heard: tuple[tuple[int, int], ...] = ()
) -> Health:
    rejected = {"shape": 2, "version": 1}
    return Health(robot, life, tick, 0.001, published, 9, rejected, heard, ((2, 1.0, 0.0, 0.1),))


def rows(it: FleetView, now: float) -> dict[int, dict[str, object]]:
    return {row["id"]: row for row in telling.snapshot(it, now)["robots"]}


def statuses(it: FleetView, now: float) -> list[object]:
    return [row["status"] for row in rows(it, now).values()]


def run_to(it: FleetView, tick: int, now: float) -> None:
    it.on_message(clock(tick - 1), now)
    it.on_message(truth(tick, y=0.001 * tick), now)


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


def goal(number: int, tick: int, x: float = 0.2, ahead: int = 0) -> GoalStatus:
    return GoalStatus(1, tick, number, "under way", (x, 0.0), ahead)


def test_goals_follow_orders_and_an_older_word_changes_nothing() -> None:
    it = view()
    run_to(it, 1, 0.0)
    assert rows(it, 0.0)[1]["goal"] == (-0.1, 0.1)
    it.on_message(goal(2, 9, ahead=3), 0.0)
    it.on_message(goal(1, 8, x=-0.2), 0.0)
    it.on_message(GoalStatus(77, 9, 1, "under way", (0.0, 0.0)), 0.0)  # not a robot of this run
    row = rows(it, 0.0)[1]
    assert (row["goal"], row["ahead"]) == ((0.2, 0.0), 3)
    assert row["distance"] == pytest.approx(0.3, abs=1e-4)
    assert telling.overview(it)["robots"][0]["goal"] == (0.2, 0.0)


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
            it.on_token(*event)
        else:
            it.on_message(event, n * 0.1)
        json.loads(msgspec.json.encode(telling.snapshot(it, n * 0.1)))
    assert json.loads(msgspec.json.encode(telling.overview(it)))["scenario"] == "three"
    assert {row["id"] for row in telling.snapshot(it, 99.0)["robots"]} <= {1, 2, 3}


def test_before_the_scenario_is_known_there_is_nothing_but_the_name() -> None:
    it = FleetView("r")
    it.on_token(1, True)
    it.on_message(truth(1), 0.0)
    assert telling.overview(it)["scenario"] is None
    frame = telling.snapshot(it, 0.0)
    assert (frame["phase"], frame["robots"], frame["samples"]) == ("searching", [], [])
    it.begin(SCENARIO, True)
    assert rows(it, 0.0)[1]["alive"] is True


def test_a_newcomer_is_a_robot_like_the_others_and_one_that_leaves_is_none() -> None:
    guest = RobotSpec(5, 0.02, (0.0, 0.2), (0.1, 0.2))
    it = FleetView("r")
    it.begin(
        replace(SCENARIO, orders=(Order(0.1, add=guest),), parts=(Part(0.035, (0.2, 0.2), (0.2, 0.1)),)), True
    )
    it.on_token(9, True)
    run_to(it, 2, 0.1)
    epoch = it.epoch
    there = Truth(3, (1, 2, 3, 5), (*truth(3).positions, guest.start), 0.02, 0.5)
    it.on_message(there, 0.15)
    it.on_message(Clock(3, 0.15, (1, 2, 3, 5), (), "", parts=(PartPlace(1, carrier=5),)), 0.15)
    assert it.epoch == epoch + 1  # viewers redraw everything
    assert rows(it, 0.2)[5]["radius"] == 0.035
    assert rows(it, 0.2)[5]["distance"] == pytest.approx(0.1)
    it.on_message(Truth(4, (1, 3, 9), ((0.0, 0.0), (0.1, 0.0), (0.0, -0.2)), 0.02, 0.5), 0.2)
    assert rows(it, 0.2).keys() == {1, 3}
    assert it.strangers == {9}  # its radius is unknown
    it.update(replace(SCENARIO, robots=(*SCENARIO.robots, RobotSpec(9, 0.01, (0.0, -0.2), (0.0, 0.2)))))
    assert it.strangers == set()
    it.on_message(Truth(5, (1, 3, 9), ((0.0, 0.0), (0.1, 0.0), (0.0, -0.1)), 0.02, 0.5), 0.25)
    assert rows(it, 0.3)[9]["distance"] == pytest.approx(0.3)


@pytest.mark.parametrize(
    ("errand", "said"), [("arrived", "at goal"), ("cancelled", "cancelled"), ("given up", "given up")]
)
def test_a_robot_that_stays_says_why(errand: OrderStatus, said: str) -> None:
    it = view()
    run_to(it, 1, 0.0)
    it.on_message(GoalStatus(1, 1, 1, errand, (it.robots[1].position[0], 0.0)), 0.0)
    assert statuses(it, 0.0) == [said, "under way", "under way"]


def test_a_dead_robot_is_an_alarm_at_once_and_the_others_are_not() -> None:
    it = view()
    run_to(it, 1, 0.0)
    it.on_token(2, False)
    assert statuses(it, 0.0) == ["under way", "dead", "under way"]
    assert [row["alarm"] for row in rows(it, 0.0).values()] == [False, True, False]


def test_a_fenced_robot_is_an_alarm_until_it_takes_part_again() -> None:
    it = view()
    down = (Standing(3, 1, (0.1, 0.0)),)
    it.on_message(clock(5, active=(1, 2), down=down), 0.0)
    assert statuses(it, 0.0)[2] == "fenced"
    it.on_message(clock(9, active=(1, 2, 3), down=down), 0.1)
    assert statuses(it, 0.1)[2] != "fenced"


def test_a_robot_that_falls_behind_its_peers_is_silent_before_its_token_goes() -> None:
    it = view(lockstep=False)
    for tick in range(1, 60):
        now = tick * 0.05
        run_to(it, tick, now)
        for robot in (1, 2):
            it.on_message(health(robot, tick, heard=((3, min(tick, 10)),)), now)
    assert statuses(it, 59 * 0.05) == ["under way", "under way", "silent"]
    assert rows(it, 59 * 0.05)[3]["age_ticks"] == 49
    assert rows(it, 59 * 0.05)[3]["age"] == pytest.approx(49 * 0.05, abs=0.06)


def test_in_a_pause_no_robot_is_silent() -> None:
    it = view()
    run_to(it, 20, 1.0)
    it.steering = Steering(paused=True)
    assert telling.snapshot(it, 60.0)["phase"] == "paused"
    assert statuses(it, 60.0) == ["under way"] * 3


def test_after_the_verdict_everybody_leaves_and_that_is_no_alarm() -> None:
    it = view()
    it.on_message(truth(7, y=0.1), 0.0)
    it.on_message(clock(7, verdict="arrived"), 0.0)
    for robot in (1, 2, 3, None):
        it.on_token(robot, False)
    frame = telling.snapshot(it, 5.0)
    assert (frame["phase"], frame["verdict"]) == ("ended", "arrived")
    assert statuses(it, 5.0) == ["at goal"] * 3


def test_the_reason_of_the_verdict_is_told_until_another_scenario_begins() -> None:
    it = view()
    it.on_message(
        msgspec.structs.replace(clock(7, verdict="deadlock"), reason="no robot moved for 10 s"), 0.0
    )
    frame = telling.snapshot(it, 0.0)
    assert frame["reason"] == "no robot moved for 10 s"
    assert "no robot moved for 10 s" in printed(table(frame))
    it.begin(SCENARIO, True)
    assert telling.snapshot(it, 0.0)["reason"] == ""


def test_a_world_that_goes_without_a_verdict_is_lost() -> None:
    it = view()
    run_to(it, 2, 0.0)
    it.on_token(None, False)
    assert telling.snapshot(it, 0.0)["phase"] == "lost"


@given(st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=120), st.integers(0, 119))
def test_no_small_clearance_is_lost_to_thinning(clearances: list[float], since: int) -> None:
    it = view()
    for tick, clearance in enumerate(clearances, start=1):
        it.on_message(truth(tick, clearance=clearance), tick * 0.001)
    frame = telling.snapshot(it, 1.0, since)
    assert len(frame["samples"]) <= 8
    if clearances[since:]:
        assert min(sample[2] for sample in frame["samples"]) == min(clearances[since:])
        assert frame["samples"][-1][0] == len(clearances)
