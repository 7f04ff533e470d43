"""No message outgrows the limit of its stream, however large the fleet and whatever has happened to it."""

import json
import math
from dataclasses import replace
from random import Random

import msgspec
import pytest

from agents.lines.separating_lines import FIRSTS
from protocol.codec import decode, encode
from protocol.keys import STREAMS, robot_key, world_key
from protocol.messages import (
    HIGHEST_ID,
    Answer,
    AnyMessage,
    Clock,
    Command,
    FirstLine,
    Grants,
    ListedBinding,
    Member,
    Proposal,
    Result,
    Roster,
    Standing,
    State,
    Tick,
)
from protocol.scenario.file import validated
from protocol.scenario.model import Control, Obstacle, ProcessFault, RobotSpec, Scenario, Time, Workspace
from protocol.scenario.network import Link, Partition
from world.coordinator.lives import note
from world.coordinator.roster import MOST as MOST_THINGS
from world.coordinator.roster import Surroundings
from world.judge.record import LISTED, Contact
from world.shell.admission import Admissions
from world.shell.pacing import Pacing
from world.shell.run import JudgedRun, Shutdown

MOST = 1000
LIFE = 2**40  # no robot has as many lives
IDS = tuple(range(HIGHEST_ID - MOST + 1, HIGHEST_ID + 1))
POINT = (-0.123456789, 0.987654321)
SPECK = Obstacle(center=(40.0, 0.0), radius=0.01)
DISK = Obstacle(center=(-40.123456789, -3.0), radius=0.123456789)
ROUNDISH = Obstacle(points=tuple((math.cos(0.1 * n) - 40.0, math.sin(0.1 * n)) for n in range(62)))


def assert_fits(message: AnyMessage, key: str) -> None:
    stream = STREAMS[type(message).__name__.lower()]
    payload = encode(message)
    assert len(payload) < stream.limit
    assert decode(key, payload) == message


def crowd() -> Scenario:
    """As many robots as there may be, with the longest ids, each on its way."""
    side = math.ceil(math.sqrt(MOST))
    robots = tuple(
        RobotSpec(
            robot, 0.04, (0.1 * (n // side), 0.1 * (n % side)), (-0.1 * (n // side) - 0.1, 0.1 * (n % side))
        )
        for n, robot in enumerate(IDS)
    )
    return Scenario(
        robots, workspace=Workspace(10.0), control=Control(k=60.0), time=Time(fence=0.05, deadlock=0.2)
    )


def bound(ids: tuple[int, ...], robot: int) -> Grants:
    """What a life of one robot is told that is bound to all others."""
    listed = [
        ListedBinding(LIFE + robot + peer, peer, (1.0, 0.0, 0.0 if robot < peer else -0.1))
        for peer in ids
        if peer != robot
    ]
    return Grants(LIFE, LIFE + 2 * HIGHEST_ID + 2, LIFE + 2 * HIGHEST_ID + 1, None, tuple(listed))


@pytest.mark.parametrize("place", [0, 500, MOST - 1])
def test_a_state_fits_after_any_partition(place: int) -> None:
    """All that it owns is unanswered, of each peer the newest, and all answers are due."""
    offers = tuple(Proposal(peer, LIFE, LIFE, *POINT, 100.25) for peer in IDS[place + 1 :])
    answers = tuple(Answer(peer, LIFE, LIFE, LIFE) for peer in IDS[:place])
    state = State(IDS[place], LIFE, LIFE, POINT, 0.1, 0.2, 0.3, POINT, proposals=offers, answers=answers)
    assert_fits(state, robot_key("r", IDS[place], "state"))


def test_a_command_with_all_first_lines_fits() -> None:
    firsts = tuple(FirstLine(LIFE + peer, -0.6, -0.8, 0.123456789) for peer in IDS[:FIRSTS])
    said = Command(IDS[0], LIFE, LIFE, POINT, 7, LIFE, (), None, LIFE, LIFE, firsts)
    assert_fits(said, robot_key("r", IDS[0], "command"))


def test_what_the_world_says_fits_while_all_take_part_and_when_all_are_fenced() -> None:
    run = JudgedRun(crowd())
    for life in run.world.lives.of.values():
        life.incarnation = LIFE
    world = run.world
    for robot in IDS:
        world.join(robot)
    told = world.open_tick()
    assert len(world.exchange.active) == MOST
    assert_fits(told[IDS[0]], robot_key("r", IDS[0], "tick"))
    assert_fits(run.clock(), world_key("r", "clock"))
    while len(world.lives.roster.standing) < MOST:
        world.open_tick()
        world.close_tick()
    (last, *_) = [m for robot, m in world.open_tick().items() if robot == IDS[0]]
    assert [each.status for each in last.roster.members] == ["standing"] * MOST
    assert_fits(last, robot_key("r", IDS[0], "tick"))
    while not world.verdict:
        world.open_tick()
        world.close_tick()
    assert str(IDS[0]) in world.referee.reason
    assert str(IDS[-1]) in world.referee.reason
    assert_fits(run.clock(), world_key("r", "clock"))
    assert_fits(world.truth, world_key("r", "truth"))


def test_a_roster_of_all_obstacles_that_there_may_be_fits() -> None:
    """Nearly as many corners as may come; and all that the scenario listed are gone."""
    wide = replace(crowd(), workspace=Workspace(1000.0), obstacles=(SPECK,) * MOST)
    obstacles = Surroundings(wide)
    for number in range(1, MOST + 1):
        obstacles.take_away(number)
    for number in range(MOST_THINGS):
        obstacles.announce((ROUNDISH if number < 62 else DISK).shape)
    assert "at a time" in obstacles.refusal(DISK, wide, [])
    obstacles.take_away(MOST + MOST_THINGS)
    assert "corners" in obstacles.refusal(ROUNDISH, wide, [])
    bindings = tuple(
        ListedBinding(LIFE - 6000 - n, -n, (1.0, 0.0, 0.1), each.points, each.radius, True)
        for n, each in enumerate(obstacles.changes, 1)
        if each.status != "gone"
    )
    roster = Roster(LIFE, tuple(Member(robot, LIFE, "live", 0.04) for robot in IDS), obstacles.changes)
    grants = bound(IDS, IDS[0])
    grants = msgspec.structs.replace(grants, bindings=(*grants.bindings, *bindings))
    tick = Tick(IDS[0], LIFE, LIFE, IDS, 7, None, roster, POINT, grants=grants)
    assert_fits(tick, robot_key("r", IDS[0], "tick"))
    assert_fits(Clock(LIFE, 1e6, IDS, (), "", obstacles=obstacles.changes), world_key("r", "clock"))
    assert ROUNDISH.points is not None
    listed = [
        ListedBinding(LIFE - n, -n, (1.0, 0.0, 0.1), ROUNDISH.points, 0.0, True) for n in range(1, 5001)
    ]
    grants = msgspec.structs.replace(
        grants, bindings=(*grants.bindings, *listed)
    )  # of all that a scenario may list
    assert_fits(msgspec.structs.replace(tick, grants=grants), robot_key("r", IDS[0], "tick"))


@pytest.mark.slow
def test_a_result_fits_whatever_happened_however_often() -> None:
    apart = tuple(Partition(float(n), n + 1.0, (IDS,)) for n in range(50))  # no more names are accepted
    restarts = tuple(ProcessFault(IDS[0], n / 7.0, "restart") for n in range(10_000))  # nor more faults
    run = JudgedRun(validated(replace(crowd(), link=Link(partition=apart), process=restarts)))
    random, world = Random(1), run.world
    totals = world.referee.record.totals
    totals.collisions = 100_000
    totals.contacts.extend(
        Contact((random.choice(IDS), random.choice(IDS)), random.random(), random.random(), -random.random())
        for _ in range(LISTED)
    )
    for robot in IDS:
        world.give_up_waiting(robot)
    world.open_tick()
    world.lives.apply_faults(2**40)
    for n in range(100_000):
        note(world.lives.fenced, (n, Standing(IDS[0], LIFE, POINT)))
    pacing = Pacing(True, 0.0)
    report = Shutdown(run, Admissions("r", world, True), pacing).report()
    assert report["collisions"] == 100_000
    assert_fits(Result(json.dumps(report)), world_key("r", "result"))
