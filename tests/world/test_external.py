"""Bound on the position of silent external robots: no farther off than their bodies can have gone."""

from dataclasses import replace

import pytest

from agents.bases.base import topics_of
from agents.bases.drive import Drive
from agents.bases.ros2 import Ros2Base
from deploy.library.load import load
from protocol.messages import Command, Report, Tick
from protocol.scenario.body import Base, Body
from protocol.scenario.model import Control, RobotSpec, Scenario, Time
from protocol.scenario.model import World as Plant
from world.external import External
from world.world import WorldCore

BODY = Body("omnidirectional", acceleration=0.5, speed=0.2, hold=0.1, error=0.1, lag=0.02, play=1e-3)
SETTING = Scenario(
    (RobotSpec(1, 0.05, (0.0, 0.0), (0.1, 0.0)),),
    time=Time(step=0.1),
    control=Control(speed=0.2),
    world=Plant("external", lease=0.5),
    body=BODY,
)
LATE = BODY.lag + Base().lateness.age  # s


@pytest.mark.parametrize("heard", [4, 20])
def test_a_robot_that_was_not_heard_stands_within_all_that_its_body_may_have_done(heard: int) -> None:
    """A lease runs from when its command was sent, which may be a moment before it is heard."""
    outside, body = External(SETTING), SETTING.body_of(1)
    outside.sense(heard)
    outside.on_command(Command(1, 1, 4, (0.1, 0.0), report=Report((0.05, 0.0), 2e-3)))
    leased = 0.5 + body.hold + 0.2 / 0.5  # then it has braked
    last = heard + 2 + int(leased / 0.1)
    for tick in range(heard + 1, last):
        outside.sense(tick)
        assert outside.resting() == {}
    outside.sense(last + 1)
    assert outside.resting() == {1: (0.05, 0.0)}
    way = 0.2 * ((heard - 4) * 0.1 + 0.2 + leased + LATE)  # ever since it was where it says
    assert outside.bounds[1] == pytest.approx(2e-3 + 1.1 * way + body.play)


def test_an_emergency_stop_has_succeeded_once_every_base_had_the_time_to_brake() -> None:
    outside, body = External(SETTING), SETTING.body_of(1)
    outside.sense(4)
    assert outside.moving() == frozenset(), "no base has ever been told to move"
    outside.on_command(Command(1, 1, 4, (0.0, 0.0), region=1, report=Report((0.05, 0.0), 2e-3)))
    outside.stop(5)
    outside.sense(5)
    assert outside.moving() == {1}, "it may be told to move in the tick that was open"
    outside.on_command(Command(1, 1, 4, (0.0, 0.0), region=1))
    outside.sense(6)
    outside.on_command(Command(1, 1, 5, (0.0, 0.0), region=1, report=Report((0.05, 0.0), 2e-3)))
    braked = 8 + int((body.hold + 0.2 / 0.5) / 0.1)
    for tick in range(6, braked):
        outside.sense(tick)
        assert outside.moving() == {1}
    outside.sense(braked + 1)
    assert outside.moving() == frozenset()


def test_a_robot_whose_lease_may_run_is_not_taken_for_static(monkeypatch: pytest.MonkeyPatch) -> None:
    """Even if the Command that was heard last is of before it obeyed a region, and all since are lost."""
    leases: list[float] = []
    monkeypatch.setattr(Drive, "command", lambda *told: leases.append(told[-1]))
    scenario = load("turtlebots-2", ["world.plant=external"], 1)
    robot = scenario.ids[0]
    base = Ros2Base(scenario, robot, topics_of(scenario, robot))
    outside = External(scenario)
    waits = Command(robot, 1, 4, (0.0, 0.0), report=Report(scenario.spec(robot).start, 2e-3))
    moves = Command(robot, 1, 5, (0.1, 0.0), region=7)
    for now, command in ((0.4, waits), (0.5, moves)):
        outside.sense(command.tick)
        base.begin(Tick(robot, 1, command.tick, scenario.ids, heard=command.tick - 1), now)
        base.obey(command, now)
    outside.on_command(waits)
    assert robot in outside.resting()
    assert leases[-1] < 0.5, "it does not move"
    outside.on_command(moves)
    base.begin(Tick(robot, 1, 6, scenario.ids, heard=5), 0.6)
    base.obey(moves, 0.6)
    assert robot not in outside.resting()
    assert leases[-1] > 0.6, "it may move"


def test_another_world_bounds_what_a_base_may_cover_until_its_lease_is_over() -> None:
    """Whatever the dead world has told, and however late a Command of its open tick is sent."""
    outside, body = External(SETTING), SETTING.body_of(1)
    outside.sense(20)
    outside.on_command(Command(1, 1, 20, (0.1, 0.0), region=1, report=Report((0.05, 0.0), 2e-3)))
    outside.sense(21)
    past = outside.past
    leased = 0.5 + body.hold + 0.2 / 0.5
    farthest = 1.1 * 0.2 * (0.2 + leased + LATE) + body.play
    assert past.bounds == {1: pytest.approx(2e-3 + farthest)}
    later = External(SETTING, past, 21)
    assert (later.places, later.founding_bounds, later.lengths) == (
        {1: (0.05, 0.0)},
        past.bounds,
        outside.lengths,
    )
    last = 23 + int(leased / 0.1)  # until then it may still move under the lease of its earlier life
    settled = last + 2 + int(LATE / 0.1)  # before, a report may be of odometry from before it stood
    for tick in (*range(21, last), *range(last + 1, settled + 1)):
        later.sense(tick)
        later.on_command(Command(1, 2, tick, (0.0, 0.0), report=Report((0.06, 0.0), 2e-3)))
        assert later.resting() == ({} if tick < last else {1: (0.06, 0.0)})
        assert tick < last or later.unsettled == ({1} if tick < settled else set())
    assert later.bounds == {1: 2e-3}


def test_a_base_that_stands_is_settled_where_it_is_known_exactly_or_after_a_while() -> None:
    outside, exact = External(SETTING), 0.1 * 0.05
    outside.on_command(Command(1, 1, 4, (0.1, 0.0), report=Report((0.05, 0.0), 0.5 * exact)))
    for tick in range(5, 60):
        outside.sense(tick)
        outside.on_command(Command(1, 2, tick, (0.0, 0.0), report=Report((0.06, 0.0), 5.0 * exact)))
        resting = outside.resting()
        assert outside.unsettled == set(resting)
    for tick, bound, now in (60, exact, 59), (61, 5.0 * exact, 120):
        outside.on_command(Command(1, 2, tick, (0.0, 0.0), report=Report((0.06, 0.0), bound)))
        outside.sense(now)
        assert outside.resting()
        assert outside.unsettled == set()


@pytest.mark.parametrize(("off", "verdict"), [(0.0, ""), (0.2498, "aborted")])  # m
def test_a_run_ends_if_a_robot_is_not_where_the_ledger_has_it(off: float, verdict: str) -> None:
    """Its first report is of another place than its start, or than a checkpoint of long ago says."""
    world = WorldCore(replace(SETTING, control=Control(k=10.0, speed=0.2)))
    life = world.join(1)
    for tick in range(3):
        world.open_tick()
        if not world.verdict:
            world.accept(Command(1, life, tick, (0.0, 0.0), report=Report((off, 0.0), 2e-3)))
            world.close_tick()
    assert world.verdict == verdict
    assert world.lives.of[1].begun == (not verdict)
    assert ("robot 1 is at (0.250, 0.000), not where" in world.referee.reason) == bool(verdict)


def test_a_contact_in_the_last_tick_outranks_a_robot_that_is_not_where_the_ledger_has_it() -> None:
    other = RobotSpec(2, 0.05, (-0.2, 0.0), (-0.1, 0.0))
    world = WorldCore(replace(SETTING, robots=(*SETTING.robots, other), control=Control(k=10.0, speed=0.2)))
    lives = {robot: world.join(robot) for robot in (1, 2)}
    for tick, place in enumerate((-0.2, 0.2)):
        world.open_tick()
        for robot, x in ((1, 0.2498), (2, place)):
            world.accept(Command(robot, lives[robot], tick, (0.0, 0.0), report=Report((x, 0.0), 2e-3)))
        world.close_tick()
    assert (world.verdict, "otherwise aborted: robot 1" in world.referee.reason) == ("collision", True)


def test_a_late_command_that_names_grants_that_were_never_made_is_not_heard() -> None:
    scenario = load("turtlebots-2", ["world.plant=external", "time.endless=true"], 1)
    world, robot = WorldCore(scenario), scenario.ids[0]
    for each in scenario.ids:
        world.join(each)
    for _ in range(2):
        world.open_tick()
        world.close_tick()
    world.open_tick()
    for command in (
        Command(robot, 1, 1, (0.0, 0.0), version=10**6),
        Command(robot, 1, 1, (0.0, 0.0), roster=10**6),
    ):
        assert not world.accept(command)
    assert world.exchange.refused == {"ledger": 2}
    assert [world.accept(Command(robot, 1, 1, (0.0, 0.0))) for _ in range(2)] == [True, False]
    world.close_tick()
    assert {each: told.heard for each, told in world.open_tick().items()} == {robot: 1, scenario.ids[1]: None}
