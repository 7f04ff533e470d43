"""Orders of where to go: what is refused and why, point after point, patrols, ends that are no arrivals."""

import math

from hypothesis import given
from hypothesis import strategies as st

from protocol.messages import Command, GoalStatus, Standing, Vector
from protocol.operations import Outcome
from protocol.scenario.model import MOST_POINTS, Journey, Operation
from tests.world.driving import STEP, advance, joined, two
from world.coordinator.missions import Missions
from world.world import WorldCore

HERE, THERE = (0.05, 0.15), (-0.05, 0.15)


def order(world: WorldCore, journey: Journey) -> Outcome:
    return world.operate(Operation(goal=journey))


def status(world: WorldCore) -> GoalStatus:
    return world.goal_statuses()[0]


def drive(world: WorldCore, most: int = 400) -> list[GoalStatus]:
    """Robot 1 goes straight to whatever goal it is told, until no order is open; what was told of it."""
    said, goal = world.missions.news(), (0.1, 0.1)
    for _ in range(most):
        goal = world.open_tick()[1].goal or goal
        (x, y), *_ = world.truth.positions
        dx, dy = goal[0] - x, goal[1] - y
        scale = min(1.0, 0.005 / math.hypot(dx, dy)) if (dx, dy) != (0.0, 0.0) else 0.0
        advance(world, {1: (scale * dx / STEP, scale * dy / STEP)})
        said += world.missions.news()
        if said and said[-1].status != "under way":
            return said
    return said


def test_point_after_point() -> None:
    world = joined(two())
    assert order(world, Journey(1, (HERE, THERE))) == Outcome(True, 1)
    assert status(world) == GoalStatus(1, 0, 1, "under way", HERE, 1)
    said = drive(world)
    assert [(each.status, each.goal, each.ahead) for each in said] == [
        ("under way", HERE, 1),
        ("under way", THERE, 0),
        ("arrived", THERE, 0),
    ]
    assert math.dist(world.truth.positions[0], THERE) <= 0.005
    assert status(world) == said[-1]


def test_a_queued_order_waits_and_another_replaces() -> None:
    world = joined(two())
    order(world, Journey(1, (HERE,)))
    queued = order(world, Journey(1, (THERE,), queue=True))
    assert (queued.number, status(world).goal, status(world).ahead) == (2, HERE, 1)
    replaced = order(world, Journey(1, (THERE,)))
    assert (replaced.number, status(world).goal, status(world).ahead) == (3, THERE, 0)


def test_a_patrol_has_no_end_and_keeps_the_run_open() -> None:
    world = joined(two())
    order(world, Journey(1, (HERE, THERE), patrol=True))
    said = drive(world, 120)
    assert len(said) > 4
    assert {each.goal for each in said} == {HERE, THERE}
    assert {each.status for each in said} == {"under way"}
    assert world.verdict == ""


def test_cancelling_stays_and_giving_up_does_too() -> None:
    world = joined(two())
    order(world, Journey(1, (HERE,)))
    advance(world, {1: (0.05, 0.0)})
    place = world.truth.positions[0]
    order(world, Journey(1, ()))
    assert status(world) == GoalStatus(1, 1, 2, "cancelled", place)
    order(world, Journey(1, (HERE,), within=3 * STEP))
    for _ in range(3):
        advance(world)
    assert status(world) == GoalStatus(1, 4, 3, "given up", place)
    assert world.open_tick()[1].goal == place


def test_what_cannot_be_is_refused_by_reason_and_changes_nothing() -> None:
    world = joined(two())
    before = status(world)
    for journey, reason in (
        (Journey(3, (HERE,)), "no robot 3"),
        (Journey(1, ((0.28, 0.0),)), "0.02 m out of the workspace"),
        (Journey(1, (HERE, (0.0, -0.3))), "out of the workspace"),
        (Journey(1, (), patrol=True), "leave out"),
    ):
        reply = order(world, journey)
        assert not reply.accepted
        assert reason in reply.text
    assert (status(world), world.missions.news()) == (before, [])
    full = Journey(1, (HERE,) * MOST_POINTS)
    assert order(world, full).accepted
    assert "at most" in order(world, Journey(1, (THERE,), queue=True)).text


def test_a_disk_that_stands_is_in_the_way_of_others_only() -> None:
    missions = Missions(two())
    down = [Standing(2, 1, HERE)]
    assert "robot 2 is down and stands there" in missions.refusal(Journey(1, (HERE,)), down)
    assert missions.refusal(Journey(2, (HERE,)), down) == ""


def test_a_goal_upon_anothers_is_accepted_with_a_warning() -> None:
    reply = order(joined(two()), Journey(1, ((0.1, -0.05),)))
    assert reply.accepted
    assert "robot 2" in reply.text


def test_a_robot_that_is_halted_stands_and_goes_on_when_released() -> None:
    world = joined(two())
    advance(world, {1: (0.1, 0.0), 2: (0.1, 0.0)})
    before = world.truth.positions
    world.open_tick()
    world.operate(Operation(halt=True))  # in the middle of a tick, with commands on their way
    for robot in world.exchange.active:
        world.accept(Command(robot, 1, 1, (0.1, 0.0)))
    world.close_tick()
    for _ in range(40):  # far longer than what counts as a deadlock
        assert world.open_tick()[1].halted
        advance(world, {1: (0.1, 0.0), 2: (0.1, 0.0)})
    assert (world.truth.positions, world.verdict) == (before, "")
    world.operate(Operation(halt=True))
    assert not world.operate(Operation(release=1)).accepted, "it was sent before the second stop"
    assert world.halted
    assert world.operate(Operation(release=2)).accepted
    assert not world.open_tick()[1].halted
    advance(world, {1: (0.1, 0.0)})
    assert world.truth.positions[0] == (before[0][0] + 0.1 * STEP, before[0][1])


def test_a_scheduled_release_lifts_no_stop_by_an_operator() -> None:
    world, stop, release = joined(two()), Operation(halt=True), Operation(halt=False)
    for _ in range(2):  # also after the scenario's own stops
        world.operate(stop, scheduled=True)
        world = WorldCore(two(), world.past)
        assert world.operate(release, scheduled=True).accepted
    for before, after in ((stop, ()), ((), stop)):
        for operation, scheduled in ((before, False), (stop, True), (after, False)):
            if operation:
                world.operate(operation, scheduled=scheduled)
        world = WorldCore(two(), world.past)
        assert world.operate(release, scheduled=True).text == "an operator has stopped the robots"
        assert world.stopped
        assert world.operate(Operation(release=world.stops)).accepted


points = st.tuples(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))


@given(st.lists(st.tuples(st.lists(points, max_size=4), st.booleans(), st.booleans()), max_size=8))
def test_whatever_is_accepted_lies_within_reach(orders: list[tuple[list[Vector], bool, bool]]) -> None:
    missions, number = Missions(two()), 0
    for given_points, queue, patrol in orders:
        journey = Journey(1, tuple(given_points), queue=queue, patrol=patrol)
        inside = all(math.hypot(*point) + 0.04 < 0.3 for point in given_points)
        accepted = missions.refusal(journey, ()) == ""
        assert accepted == (inside and (bool(given_points) or not (queue or patrol)))
        if accepted:
            number += 1
            assert missions.accept(journey, 0, (0.0, 0.0)).number == number
            assert missions.pending == bool(given_points)
