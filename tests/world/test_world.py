import json
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocol.errors import JoinError
from protocol.messages import Command
from protocol.scenario.body import Actuation
from protocol.scenario.model import Obstacle, Operation, Order, Sensing, Time
from tests.world.driving import advance, joined, play, toward, two
from world.report import result_of
from world.world import WorldCore

FAULTS = {
    "sensing": (Sensing(delay=(0.0, 0.3), noise=0.002, dropout=0.2),),
    "actuation": Actuation(noise=0.1),
}


def test_joining_twice_or_under_an_unknown_id_is_refused():
    world = joined(two())
    with pytest.raises(JoinError, match="robot 1 is already running; stop it or use another id"):
        world.join(1)
    with pytest.raises(JoinError, match=r"no robot 3 in scenario 'scenario'; there are 1, 2"):
        world.join(3)


def test_measurements_lead_from_truth_to_truth_bit_for_bit():
    setting = two(actuation=Actuation(noise=0.2))
    world = joined(setting)
    before = {1: (-0.1, 0.1), 2: (-0.1, -0.1)}
    for tick in range(30):
        told = world.open_tick()
        assert world.open_tick() == told
        truth = dict(zip(world.truth.robots, world.truth.positions, strict=True))
        for robot, opened in told.items():
            sense = opened.sense
            assert opened.tick == sense.stamp == tick
            assert opened.active == (1, 2)
            assert (opened.roster is None) == (tick > 0)
            assert sense.position == truth[robot]
            dx, dy = sense.displacement
            assert truth[robot] == (before[robot][0] + dx, before[robot][1] + dy)
        before, wanted = truth, toward(world, setting)
        advance(world, wanted if tick < 20 else {1: wanted[1]})


def follow_measurements(seed, reverse=False):
    """Robots that steer by what they are told, with all faults; commands arrive in either order."""
    setting = two(seed=seed, **FAULTS)
    world = joined(setting)
    for _ in range(60):
        told = world.open_tick()
        for robot, heard in sorted(told.items(), reverse=reverse):
            x, y = heard.sense.position or (0.0, 0.0)
            gx, gy = setting.spec(robot).goal
            world.accept(Command(robot, 1, world.tick, ((gx - x) / 4, (gy - y) / 4)))
        world.close_tick()
    return result_of(world)


@settings(max_examples=12)
@given(st.integers(0, 2**63 - 1))
def test_the_same_seed_gives_the_same_run_whatever_order_commands_arrive_in(seed):
    assert follow_measurements(seed) == follow_measurements(seed, reverse=True)
    assert (
        follow_measurements(seed)["trajectory_sha256"] != follow_measurements(seed ^ 1)["trajectory_sha256"]
    )


def test_the_report_is_plain_json_and_states_faults_as_the_scenario_does():
    first, world = joined(two(**FAULTS)).truth, play(two(**FAULTS))
    report, rises = result_of(world), world.referee.record.totals.increases
    assert report["phi"] == {"first": first.phi, "last": world.truth.phi, "increases": rises}
    assert list(report["positions"].values()) == [list(place) for place in world.truth.positions]
    assert json.loads(json.dumps(report, allow_nan=False)) == report
    assert report["faults"]["sensing"] == [
        {"delay": [0.0, 0.3], "noise": 0.002, "noise_bound": None, "bias": [0.0, 0.0]}
        | {"dropout": 0.2, "robots": None, "heading": 0.0, "contradiction": "stand"}
    ]
    assert report["faults"]["actuation"] == {"noise": 0.1}
    assert report["faults"]["link"]["partition"] == []
    counts = report["faults"]["measurements"]
    assert counts["delayed"] > 0
    assert counts["missing"] >= counts["dropped"] > 0


@pytest.mark.parametrize("is_open", [True, False])
def test_what_is_removed_is_fenced_in_the_same_step_and_leaves_nothing(is_open: bool) -> None:
    """docs/safety.md, 6.4: no command of that life is executed any more; its peers hear that it is gone."""
    setting = two()
    world = joined(setting)
    advance(world, toward(world, setting))
    told = world.open_tick() if is_open else {}
    assert world.operate(Operation(remove=2)).text == ""
    if is_open:  # the last that is executed
        for robot in (1, 2):
            assert world.accept(Command(robot, told[robot].incarnation, world.tick, (0.05, 0.0), roster=0))
        world.close_tick()
    (fenced,) = result_of(world)["faults"]["fenced"]
    assert fenced == {"robot": 2, "incarnation": 1, "tick": world.tick + 1}
    assert world.scenario.ids == (1,)
    told = world.open_tick()
    roster = told[1].roster
    assert {member.robot: member.status for member in roster.members}[2] == "gone"
    assert not world.accept(Command(2, 1, world.tick, (0.05, 0.0), roster=0))
    assert result_of(world)["rejected_commands"] == {"fenced": 1}
    assert world.accept(Command(1, 1, world.tick, (0.0, 0.0), roster=roster.version))
    world.close_tick()
    assert world.truth.robots == (1,)


def test_a_world_goes_on_from_a_fleet_whose_last_body_with_inertia_has_left() -> None:
    specs = tuple(
        replace(spec, body=body) for spec, body in zip(two().robots, ("robotarium", None), strict=True)
    )
    world = joined(two(robots=specs))
    advance(world)
    world.operate(Operation(remove=1))
    advance(world)
    after = WorldCore(two(robots=specs), world.past)
    assert after.truth.tick == after.tick == 2
    assert after.simulation.plant.refusal(specs[0]) == ""


def test_what_appears_with_a_tick_counts_though_it_is_taken_away_before_the_next() -> None:
    world = joined(two())
    advance(world)
    world.operate(Operation(place=Obstacle(center=(-0.1, 0.0), radius=0.05)))
    while not world.lives.obstacles.standing:
        advance(world)
    assert world.operate(Operation(take=1)).accepted
    assert world.truth.clearance == result_of(world)["min_clearance"] == pytest.approx(0.01)


@pytest.mark.parametrize("orders", [(), (Order(3.0, remove=2),)])
def test_robots_that_are_gone_end_a_run_only_once_no_order_is_to_come(orders):
    world = joined(two(orders=orders, time=Time(limit=9.0, fence=0.1, deadlock=9.0)))
    while not world.verdict:
        world.open_tick()
        world.close_tick()
    assert (world.tick > world.scenario.ticks(3.0)) == bool(orders)
