from dataclasses import replace

import pytest

from protocol.errors import JoinError
from protocol.messages import Command, Member, Standing
from protocol.scenario.model import Operation, ProcessFault, Time
from tests.world.driving import STEP, advance, joined, two
from world.coordinator.records import Life
from world.report import result_of
from world.world import WorldCore

FENCE = 4  # ticks
PATIENT = Time(step=STEP, limit=100.0, fence=FENCE * STEP, deadlock=50.0)
RIGHT = {1: (0.02, 0.0), 2: (0.02, 0.0)}


def faulty(*events: tuple[int, float, str]) -> WorldCore:
    """A world with process faults at times given in ticks, all robots joined."""
    faults = tuple(ProcessFault(robot, at * STEP, event) for robot, at, event in events)
    return joined(two(process=faults, time=PATIENT))


def advance_to(world: WorldCore, tick: int) -> None:
    while world.tick < tick:
        advance(world, RIGHT)


def place(world: WorldCore, robot: int) -> tuple[float, float]:
    return world.truth.positions[world.truth.robots.index(robot)]


def radius_held(world: WorldCore, robot: int) -> float:
    """That of the place or region which the ledger has first for a robot's disk, m."""
    return world.lives.keeper._ledger.disks[robot].held.regions[0][1].shape.around.radius


def test_a_lost_robot_stands_and_is_fenced_after_its_silence():
    world = joined(two(time=PATIENT))
    advance_to(world, 2)
    stood = place(world, 2)
    world.open_tick()
    world.accept(Command(2, 1, 2, (0.02, 0.0)))
    assert world.lost(2, "is gone")
    assert not world.lost(2, "is gone")
    advance_to(world, 2 + FENCE)
    assert (world.exchange.active, world.lives.roster.standing) == ((1,), ())
    advance_to(world, 3 + FENCE)
    assert world.lives.roster.standing == (Standing(2, 1, stood),)
    told = world.open_tick()
    assert told[1].roster == told[2].roster  # it may still listen
    assert told[1].roster.members[1] == Member(2, 1, "standing", 0.04, stood)
    assert told[1].active == told[2].active == (1,)
    assert not world.accept(Command(2, 1, world.tick, (0.1, 0.0)))
    advance_to(world, 20)
    assert place(world, 2) == stood
    assert result_of(world)["rejected_commands"] == {"fenced": 1}
    assert result_of(world)["missed_commands"] == 1
    assert result_of(world)["faults"]["fenced"] == [{"robot": 2, "incarnation": 1, "tick": 3 + FENCE}]
    assert [each["reason"] for each in result_of(world)["faults"]["given_up"]] == ["is gone"]


def test_a_lost_robot_that_is_started_again_is_waited_for():
    world = joined(two(time=PATIENT))
    advance_to(world, 3)
    world.lives.expect(2)  # it was not lost
    assert not world.give_up_waiting(2)
    assert world.lives.awaited == frozenset()
    world.lost(2)
    world.lives.expect(2)
    assert world.lives.awaited == {2}
    assert world.open_tick() == {}  # its process, if it lives on, could take part otherwise
    with pytest.raises(RuntimeError, match="tick 3 is not open"):
        world.close_tick()
    assert world.join(2) == 2
    assert world.open_tick()[1].roster.members[1] == Member(2, 2, "live", 0.04)
    world.lost(1)
    world.lives.expect(1)
    world.give_up_waiting(1, "is late")
    assert world.open_tick()[2].active == (2,)
    assert result_of(world)["faults"]["given_up"][0]["reason"] == "is late"
    advance(world)
    world.join(1)
    world.lives.fence(world.tick + FENCE, 1, place(world, 1), 0.0)  # before it begins
    assert world.open_tick()[1].grants is None
    assert not world.lives.keeper.lives(1)


def test_a_live_robot_is_fenced_unless_it_sends_a_command_in_time():
    world = joined(two(time=PATIENT))
    for tick in range(11 * FENCE):
        assert world.open_tick()[1].active == (1, 2)
        world.accept(Command(1, 1, tick, (0.0, 0.0)))
        if tick % FENCE == FENCE - 1 and tick < 10 * FENCE:
            assert world.accept(Command(2, 1, tick, (0.0, 0.0)))
        assert world.lives.roster.standing == ()
        world.close_tick()
    assert [down.robot for down in world.lives.roster.standing] == [2]
    assert world.open_tick()[1].active == (1,)
    assert result_of(world)["missed_commands"] == 11 * FENCE - 10


def test_a_life_begins_once_its_disk_was_reported_at_rest():
    world = joined(two(time=PATIENT))
    advance(world)
    world.lost(2)
    world.join(2)
    versions = []
    for unsettled in ({2}, {2}, set()):
        assert world.lives.begin({2: place(world, 2)}, {}, unsettled) == ""
        assert world.lives.keeper.lives(2) == (not unsettled)
        versions.append(world.lives.keeper.version)
    assert versions[0] == versions[1]  # that of the life before is over only once


def test_a_life_begins_where_its_disk_was_reported_no_matter_how_little_was_known_at_its_fencing():
    world = joined(two(time=PATIENT))
    advance(world)
    world.lives.fence(world.tick + FENCE, 2, place(world, 2), 0.05)
    assert radius_held(world, 2) == pytest.approx(0.04 + 0.05)
    world.lives.unload(2, 0.03)
    assert radius_held(world, 2) == pytest.approx(0.03 + 0.05)
    world.join(2)
    assert world.lives.begin({2: place(world, 2)}, {2: 0.001}) == ""
    assert radius_held(world, 2) == pytest.approx(0.03 + 0.001)


def test_a_short_pause_ends_in_the_same_life():
    world = faulty((2, 6, "resume"), (2, 3, "pause"))
    advance_to(world, 3)
    assert world.open_tick().keys() == {1}
    with pytest.raises(JoinError, match="robot 2 is paused by the scenario"):
        world.join(2)
    world.lost(2)  # its presence may go while it is stopped
    advance_to(world, 6)
    told = world.open_tick()
    assert world.lives.awaited == frozenset()
    assert (told[2].incarnation, told[2].active, world.lives.roster.standing) == (1, (1, 2), ())


def test_a_long_pause_ends_in_a_new_life():
    world = faulty((2, 3, "pause"), (2, 12, "resume"))
    advance_to(world, 12)
    told = world.open_tick()
    assert world.lives.awaited == {2}
    assert told.keys() == {2}  # it learns that it was fenced; no other robot begins the tick
    assert told[2].roster.members[1].position == place(world, 2)
    assert world.lives.roster.standing == (Standing(2, 1, place(world, 2)),)
    assert world.join(2) == 2
    assert world.open_tick()[1].active == (1, 2)
    world.close_tick()
    assert world.lives.up == (1, 2)  # its silence has begun


def test_a_process_that_is_paused_while_it_restarts_is_awaited_once_it_is_resumed():
    world = faulty((2, 3, "restart"), (2, 3, "pause"), (2, 6, "resume"))
    advance_to(world, 6)
    assert world.open_tick().keys() == set()
    assert world.lives.awaited == {2}


@pytest.mark.parametrize("event", ["kill", "pause", "restart"])
def test_faults_of_the_first_tick_wait_until_everybody_is_there(event):
    world = WorldCore(two(process=(ProcessFault(2, 0.0, event),), time=PATIENT))
    world.join(1)
    assert world.open_tick() == {}
    assert (world.lives.founded, world.lives.awaited) == (False, {2})
    world.join(2)
    told = world.open_tick()
    assert world.lives.founded
    if event == "restart":
        assert (world.lives.awaited, told) == ({2}, {})
        world.join(2)
        told = world.open_tick()
    assert world.exchange.active == ((1, 2) if event == "restart" else (1,))


def test_a_robot_that_never_starts_is_a_disk_that_stands():
    world = joined(two(time=PATIENT), [1])
    world.give_up_waiting(2)
    assert world.open_tick().keys() == {1}
    assert world.lives.roster.members[2] == Member(2, 0, "standing", 0.04, (-0.1, -0.1))
    assert not world.lives.keeper.lives(2)
    advance_to(world, FENCE)
    assert world.lives.roster.standing == (Standing(2, 0, (-0.1, -0.1)),)
    assert not world.lives.keeper.lives(2)
    after = WorldCore(world.scenario, world.past)
    assert after.lives.up == ()
    assert {each.robot: each.incarnation for each in after.lives.roster.standing} == {1: 1, 2: 0}
    after.lives.found({1: 0.04}, {1: (0.0, 0.0)}, {1: 0.01})
    assert radius_held(after, 1) == pytest.approx(0.04 + 0.01)


def test_a_fault_of_a_robot_without_a_disk_is_passed_over():
    world = faulty((2, 3, "restart"), (1, 4, "kill"))
    advance(world)
    world.operate(Operation(remove=2))
    advance_to(world, 5)
    for each in (world, WorldCore(world.scenario, world.past)):
        assert [(tick, fault.robot) for tick, fault in each.lives.applied] == [(4, 1)]
        assert each.lives.passed_over == ((3, 2),)
        assert each.lives.fenced == world.lives.fenced != []
        assert each.lives.keeper.version >= world.lives.keeper.version
    assert world.lives.awaited == frozenset()
    assert result_of(world)["faults"]["process"] == [{"robot": 1, "at": 4 * STEP, "event": "kill", "tick": 4}]


def test_a_robot_that_is_removed_and_added_again_may_join_once_its_disk_is_there():
    world = joined(two(time=PATIENT))
    world.open_tick()
    world.lost(2)
    advance_to(world, 2 * FENCE)
    assert world.operate(Operation(remove=2)).accepted
    advance(world)
    assert (world.lives.expect(2), world.lives.awaited) == (False, frozenset())
    with pytest.raises(JoinError, match="robot 2 is gone"):
        world.join(2)
    for robot in (1, 2):
        world.lives.dismiss(robot)
    assert world.open_tick().keys() == {1}
    world.close_tick()
    for spec in (replace(two().spec(2), id=robot, start=(0.1 * robot - 0.2, -0.1)) for robot in (2, 3)):
        assert world.operate(Operation(add=spec)).accepted
    with pytest.raises(JoinError, match="robot 2 is appearing"):
        world.join(2)
    while world.lives.roster.status(2) == "appearing":
        assert world.lives.newcomers == ()
        advance(world)
    advance_to(world, world.tick + 2 * FENCE)
    assert (world.lives.newcomers, world.lives.awaited) == ((2, 3), frozenset())
    assert len(result_of(world)["faults"]["fenced"]) == 1  # no other life has ended
    assert [world.lives.expect(robot) for robot in (2, 3)] == [False, True]
    for stop in (Life.pause, Life.kill):
        stop(world.lives.of[2])
        assert world.lives.newcomers == (3,)
    assert (world.join(2), world.join(3)) == (2, 1)
    assert world.lives.newcomers == ()


@pytest.mark.parametrize(("event", "first"), [("pause", 2 + 2 * FENCE), ("restart", None)])
def test_a_robot_that_is_down_is_gone_for_good_unless_it_will_be_restarted(event, first):
    world = faulty((2, 3, "kill"), (2, 50, event))
    advance_to(world, 4)
    assert not world.lives.gone_for_good(100)  # it is not fenced yet
    advance_to(world, 20)
    assert next(filter(world.lives.gone_for_good, range(40)), None) == first


def test_no_command_is_recorded_twice_nor_before_its_life_has_begun():
    world = joined(two(time=PATIENT))
    world.open_tick()
    lives, held = world.lives, world.lives.keeper._ledger.disks[2].held
    assert [lives.on_command(Command(1, 1, 0, (0.0, 0.0))) for _ in range(2)] == [True, False]
    world.lost(2)
    world.join(2)
    assert lives.on_command(Command(2, 2, 1, (0.0, 0.0), version=held.granted, region=held.granted))
    assert held.acknowledged < held.granted
