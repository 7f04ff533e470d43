"""No message outgrows the limit of its stream, however large the fleet and whatever has happened to it."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from random import Random

import msgspec
import pytest

from agents.lines.negotiation import OUTSTANDING
from agents.lines.separating_lines import SeparatingLines
from agents.peers.neighbours import Neighbours
from agents.peers.state import PeerState
from protocol.codec import decode, encode
from protocol.kernel.pair import Owner
from protocol.keys import robot_key, world_key
from protocol.line import Line
from protocol.messages import (
    HIGHEST_ID,
    AnyMessage,
    Command,
    FirstLine,
    Grants,
    ListedBinding,
    Result,
    Standing,
    State,
)
from protocol.scenario.file import validated
from protocol.scenario.model import Control, Obstacle, ProcessFault, RobotSpec, Scenario, Time, Workspace
from protocol.scenario.network import Link, Partition
from protocol.streams import STREAMS
from world.coordinator.lives import note
from world.coordinator.roster import MOST as MOST_THINGS
from world.coordinator.roster import Surroundings
from world.judge.record import LISTED, Contact
from world.shell.run import JudgedRun

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


def cut_off(place: int) -> SeparatingLines:
    """The lines of one of many after a long partition: all that it owns is unanswered, answers are due."""
    lines = SeparatingLines(IDS[place], 0.04, speed=0.1, period=0.05)
    lines.hear(bound(IDS, IDS[place]), Neighbours(dict.fromkeys(IDS, 0.04)))
    lines.locate(LIFE, POINT, 1e-3)
    for n, bond in enumerate(lines._lines.values()):
        bond.state = PeerState(bond.peer, LIFE, LIFE, True, 9.0, 9.0, 0.1, 1.0, 1.0, *POINT, radius=0.04)
        bond.answers_left = 3
        owner = bond.bound.lines
        if isinstance(owner, Owner):
            owner.number = owner.seen = LIFE
            for turn in range(OUTSTANDING):
                owner.propose(Line(math.cos(n + turn), math.sin(n + turn), 100.0 + turn), True)
        bond.renew()
    return lines


@pytest.mark.slow
@pytest.mark.parametrize("place", [0, 500, MOST - 1])
def test_a_state_fits_after_any_partition(place: int) -> None:
    ledger = cut_off(place)
    proposals, answers = ledger.entries(POINT)
    state = State(IDS[place], LIFE, LIFE, POINT, 0.1, 0.2, 0.3, POINT, proposals=proposals, answers=answers)
    assert_fits(state, robot_key("r", IDS[place], "state"))
    assert len(answers) == place
    said = [(offer.peer, offer.number) for offer in proposals]
    assert said == [(peer, LIFE + OUTSTANDING) for peer in IDS[place + 1 :]]  # of each the newest


def test_a_command_with_all_first_lines_fits() -> None:
    lines = SeparatingLines(IDS[0], 0.04, speed=0.1, period=0.05)
    for peer in IDS[1:]:
        lines._firsts[LIFE + peer] = FirstLine(LIFE + peer, *POINT, 0.123456789)
    said = Command(IDS[0], LIFE, LIFE, POINT, 7, LIFE, (), None, LIFE, LIFE, lines.firsts())
    assert_fits(said, robot_key("r", IDS[0], "command"))


def test_what_the_world_says_fits_while_all_take_part_and_when_all_are_fenced() -> None:
    run = JudgedRun(crowd())
    for life in run.world.coordinator.lives.of.values():
        life.incarnation = LIFE
    world = run.world
    for robot in IDS:
        world.coordinator.join(robot)
    told = world.open_tick()
    assert len(world.coordinator.active) == MOST
    assert_fits(told[IDS[0]], robot_key("r", IDS[0], "tick"))
    assert_fits(run.clock(), world_key("r", "clock"))
    while len(world.coordinator.lives.roster.standing) < MOST:
        world.open_tick()
        world.close_tick()
    (last, *_) = [m for robot, m in world.open_tick().items() if robot == IDS[0]]
    assert last.roster is not None
    assert [each.status for each in last.roster.members] == ["standing"] * MOST
    assert_fits(last, robot_key("r", IDS[0], "tick"))
    while not world.verdict:
        world.open_tick()
        world.close_tick()
    assert str(IDS[0]) in world.reason
    assert str(IDS[-1]) in world.reason
    assert_fits(run.clock(), world_key("r", "clock"))
    assert_fits(world.truth, world_key("r", "truth"))


@pytest.mark.slow
def test_a_roster_of_all_obstacles_that_there_may_be_fits() -> None:
    run = JudgedRun(crowd())
    for life in run.world.coordinator.lives.of.values():
        life.incarnation = LIFE
    lives = run.world.coordinator.lives
    for robot in IDS:
        run.world.coordinator.join(robot)
    wide = replace(crowd(), workspace=Workspace(1000.0), obstacles=(SPECK,) * MOST)
    lives.obstacles = lives.roster.obstacles = Surroundings(wide)
    lives.keeper.found({}, dict.fromkeys(range(1, MOST + 1), SPECK.shape))
    assert all(lives.take_away(number) for number in range(1, MOST + 1))
    for number in range(MOST_THINGS):
        order = ROUNDISH if number < 62 else DISK  # nearly as many corners as may come
        lives.announce(order.shape)
    assert "at a time" in lives.obstacles.refusal(DISK, wide, [])
    lives.take_away(MOST + MOST_THINGS)
    assert "corners" in lives.obstacles.refusal(ROUNDISH, wide, [])
    told = run.world.open_tick()[IDS[0]]
    obstacles = [
        ListedBinding(LIFE + n, -n, (1.0, 0.0, 0.1), ROUNDISH.points, 0.0, True)
        if n <= 62
        else ListedBinding(LIFE + n, -n, (1.0, 0.0, 0.1), (POINT,), DISK.radius, True)
        for n in range(1, MOST_THINGS + 1)
    ]
    grants = bound(IDS, IDS[0])
    told = msgspec.structs.replace(
        told, grants=msgspec.structs.replace(grants, bindings=(*grants.bindings, *obstacles))
    )
    assert_fits(told, robot_key("r", IDS[0], "tick"))
    assert_fits(run.clock(), world_key("r", "clock"))


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
    world.coordinator.found(world.simulation.places, {})
    world.coordinator.lives.apply_faults(2**40)
    for n in range(100_000):
        note(world.coordinator.lives.fenced, (n, Standing(IDS[0], LIFE, POINT)))
    report = run.report([], 0, 0.0)
    assert report["collisions"] == 100_000
    assert_fits(Result(json.dumps(report)), world_key("r", "result"))
