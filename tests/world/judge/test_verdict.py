import pytest

from protocol.scenario.model import Journey, Order, ProcessFault, Time
from protocol.scenario.network import Link, Partition
from tests.world.driving import STEP, advance, joined, play, scenario, toward, two
from world.report import result_of
from world.world import WorldCore

DEADLOCK = 10  # ticks, as in `driving.scenario`


def test_arrived_means_all_robots_at_once():
    setting = two()
    world = joined(setting)
    for _ in range(60):
        advance(world, {1: toward(world, setting)[1]})
        if world.verdict:
            break
    assert world.verdict == "deadlock"
    assert result_of(world)["arrived"] == [1]
    assert result_of(world)["path_lengths"] == {"1": pytest.approx(0.2), "2": 0.0}
    world = play(setting)
    assert (world.verdict, result_of(world)["arrived"]) == ("arrived", [1, 2])
    assert result_of(world)["ticks"] == 39  # 0.2 m less the tolerance, at 5 mm a tick
    assert result_of(world)["nrl"] == pytest.approx(0.195 / 0.2)


def test_timeout_at_the_limit():
    setting = two(time=Time(step=STEP, limit=1.02, deadlock=5.0))
    world = joined(setting)
    for _ in range(21):
        assert world.verdict == ""
        advance(world)
    assert world.verdict == "timeout"
    assert world.referee.reason == "1.02 s are over; robots 1, 2 are not at the goal"
    assert result_of(world)["sim_time"] == pytest.approx(1.05)


def test_a_timeout_says_what_is_still_to_come():
    """No run in which all have arrived, or none moves, is over while orders are to come."""
    there = ((0.1, 0.0), (0.1, 0.0))
    orders = (Order(5.0, goal=Journey(1, ((0.2, 0.0),))),)
    world = joined(scenario(there, orders=orders, time=Time(step=STEP, limit=0.5, deadlock=0.2)))
    while not world.verdict:
        advance(world)
    assert (world.verdict, world.referee.reason) == ("timeout", "0.5 s are over; orders are still to come")


def test_deadlock_when_no_robot_gets_away_from_where_it_was():
    world = joined(two())
    for tick in range(DEADLOCK):
        assert world.verdict == ""
        advance(world, {1: (0.05 * (-1) ** tick, 0.0)})  # trembling is not moving
    assert world.verdict == "deadlock"
    assert world.referee.reason == "no robot moved for 0.5 s; robots 1, 2 are not at the goal"


@pytest.mark.parametrize(
    "fault",
    [
        {"process": (ProcessFault(1, 1.1, "pause"), ProcessFault(1, 1.2, "resume"))},
        {"link": Link(partition=(Partition(0.0, 1.2, ((1,), (2,))),))},
    ],
)
def test_no_deadlock_while_the_scenario_has_a_change_in_store(fault):
    world = joined(two(**fault))
    while not world.verdict:
        advance(world)
    assert (world.verdict, world.tick) == ("deadlock", 24 + DEADLOCK)


def test_a_collision_outranks_at_the_end_and_the_run_goes_on():
    world = play(scenario(((-0.1, 0.0), (0.1, 0.0)), ((0.1, 0.01), (-0.1, 0.01))))
    report = result_of(world)
    assert (world.verdict, report["collisions"], report["arrived"]) == ("collision", 1, [1, 2])
    assert world.referee.reason == "contacts: 1; otherwise arrived: all robots are at their goals"
    assert report["min_clearance"] == pytest.approx(0.01 - 0.08)


@pytest.mark.parametrize("verdict", ["interrupted", "aborted"])
def test_the_shell_may_end_a_run_once(verdict):
    world = joined(two())
    advance(world)
    world.finish(verdict, "because")
    world.finish("timeout", "later")
    assert (world.verdict, world.referee.reason) == (verdict, "because")


def test_aborted_when_the_others_are_down_for_good():
    """Robot 2 is killed at 0.5 s, fenced 0.2 s later, and given up 0.2 s after that."""
    setting = two(process=(ProcessFault(2, 0.5, "kill"),), time=Time(limit=30.0, fence=0.2, deadlock=20.0))
    world = play(setting)
    assert world.verdict == "aborted"
    assert world.referee.reason == "robot 2 is down for good; the others are at their goals"
    assert result_of(world)["arrived"] == [1]
    assert result_of(world)["down"] == [2]


def test_not_aborted_while_processes_may_yet_be_started_again():
    kills = ProcessFault(1, 0.0, "kill"), ProcessFault(2, 0.1, "kill")
    setting = two(process=kills, time=Time(limit=30.0, fence=0.2, deadlock=20.0))
    world = WorldCore(setting, returning=2.0)
    for robot in setting.ids:
        world.join(robot)
    while not world.verdict:
        advance(world)
    silent = setting.ticks(0.1)  # since this tick
    assert world.tick == silent + setting.ticks(setting.time.fence) + setting.ticks(2.0)
    assert world.referee.reason == "robots 1, 2 are down for good"


def test_not_aborted_while_a_restart_is_scheduled():
    faults = (ProcessFault(2, 0.5, "kill"), ProcessFault(2, 8.0, "restart"))
    setting = two(process=faults, time=Time(limit=30.0, fence=0.2, deadlock=20.0))
    world = joined(setting)
    while not world.lives.awaited:
        advance(world, toward(world, setting))
        world.open_tick()
    assert (world.tick, world.verdict) == (160, "")
    assert world.join(2) == 2
    while not world.verdict:
        advance(world, toward(world, setting))
    assert world.verdict == "arrived"


def test_a_robot_that_is_down_at_its_goal_has_arrived():
    setting = two(process=(ProcessFault(2, 2.2, "kill"),))
    world = joined(setting)
    while not world.verdict:
        advance(world, {1: (0.05, 0.0), 2: toward(world, setting)[2]})
    assert world.verdict == "arrived"
    assert world.exchange.active == (1,)
