"""The core of a robot: what it is told may come in any order in which a network can bring it."""

from functools import cache

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from agents.peers.state import PeerState, addressed_to, plausible
from agents.robot import Robot
from deploy.library.load import load
from protocol.messages import Command, Member, Proposal, Roster, Sense, State, Tick
from world.world import WorldCore

SCENARIO = load("swap-4")
IDS = SCENARIO.ids
OWN, *OTHERS = IDS
TICKS = 12
orders = st.lists(st.permutations([OWN, *OTHERS]), min_size=TICKS, max_size=TICKS)


def robots() -> tuple[WorldCore, dict[int, Robot]]:
    world = WorldCore(SCENARIO)
    lives = {robot: world.join(robot) for robot in IDS}
    return world, {robot: Robot(SCENARIO, robot, life) for robot, life in lives.items()}


def heard(state: State) -> PeerState:
    return addressed_to(OWN, state, SCENARIO.spec(state.robot).radius)


@cache
def said() -> list[tuple[Tick, dict[int, State], Command]]:
    """Ticks and Commands of robot OWN, tick by tick, if all robots are in step."""
    world, fleet = robots()
    ticks = []
    for _ in range(TICKS):
        told = world.open_tick()
        states = {i: robot.begin(told[i]) for i, robot in fleet.items()}
        for i, robot in fleet.items():
            for peer in IDS:
                if peer != i:
                    robot.inbox.on_state(addressed_to(i, states[peer], SCENARIO.spec(peer).radius))
        commands = {i: robot.command() for i, robot in fleet.items()}
        for command in commands.values():
            world.accept(command)
        world.close_tick()
        ticks.append((told[OWN], states, commands[OWN]))
    return ticks


@given(orders)
def test_commands_are_the_same_in_whatever_order_its_peers_are_heard(orders: list[list[int]]) -> None:
    robot = robots()[1][OWN]
    for order, (opened, states, command) in zip(orders, said(), strict=True):
        for count, each in enumerate(order):
            if each == OWN:
                assert robot.begin(opened) == states[OWN]
            else:
                robot.inbox.on_state(heard(states[each]))
            told = OWN in order[: count + 1]
            assert not told or robot.inbox.complete == (count == len(order) - 1)
        assert robot.command() == command


@pytest.mark.parametrize(("halted", "stopped"), [(False, False), (True, False), (False, True)])
def test_a_robot_stands_while_its_fleet_is_halted_or_it_is_stopped(halted: bool, stopped: bool) -> None:
    robot = robots()[1][OWN]
    for opened, states, _ in said():
        robot.begin(replace(opened, halted=halted))
        robot.stopped = stopped
        for peer in OTHERS:
            robot.inbox.on_state(heard(states[peer]))
        velocity = robot.command().velocity
    assert (velocity == (0.0, 0.0)) is (halted or stopped)


def test_a_later_life_begins_as_the_disk_that_its_earlier_one_was() -> None:
    """Which may have taken up a part; before its first command no module asks for its load."""
    first = said()[0][0]
    members = tuple(replace(m, radius=0.07) if m.robot == OWN else m for m in first.roster.members)
    robot = robots()[1][OWN]
    robot.begin(replace(first, roster=replace(first.roster, members=members)))
    assert robot._filter.radius == 0.07


def test_a_missing_life_holds_up_no_robot() -> None:
    """On an open network any process may say so: the true world's message is then no news, but arrives."""
    robot = robots()[1][OWN]
    (first, states, _), (second, later, _) = said()[:2]
    robot.begin(first)
    for peer in OTHERS:
        robot.inbox.on_state(heard(replace(states[peer], incarnation=999)))
    robot.command()
    robot.begin(second)
    for peer in OTHERS:
        robot.inbox.on_state(heard(later[peer]))
    assert robot.inbox.complete


def test_a_robot_that_knows_nothing_any_more_adopts_nothing() -> None:
    """A line that fitted where it was taken to be need not fit where it is."""
    world, fleet = robots()
    robot, owner = fleet[IDS[-1]], IDS[0]
    place = SCENARIO.spec(robot.robot).start
    tick = replace(world.open_tick()[robot.robot], sense=Sense(place, 0, 0.0, (0.0, 0.0)))
    robot.begin(tick)
    robot.command()
    (bond,) = (each for each in robot._filter.lines._each if each.peer == owner)
    held = bond.end.obeyed
    robot.reset_estimate()
    robot.begin(replace(tick, tick=1, roster=None, grants=None, sense=Sense(None, 1, 0.0, (0.0, 0.0))))
    (line,) = held
    offer = Proposal(robot.robot, bond.end.number, 1, line.nx, line.ny, line.offset)
    state = State(owner, 1, 1, SCENARIO.spec(owner).start, 0.0, 1.0, 1.0, (0.0, 0.0), proposals=(offer,))
    robot.inbox.on_state(addressed_to(robot.robot, state, SCENARIO.spec(owner).radius))
    assert robot.command().velocity == (0.0, 0.0)
    end = bond.end.lines
    assert (end.seen, end.held_number, end.obeyed()) == (1, 0, held)


def test_a_robot_that_senses_nothing_reports_no_place() -> None:
    """Its base may have moved since it sensed: an earlier place is none of this tick."""
    scenario = load("turtlebots-2", ["world.plant=external"], 1)
    own, *_ = scenario.ids
    robot = Robot(scenario, own, 1, lockstep=False)
    sense = Sense(scenario.spec(own).start, 0, 1e-3, (0.0, 0.0), 0.0)
    robot.begin(Tick(own, 1, 0, scenario.ids), sense)
    assert robot.command().report is not None
    robot.begin(Tick(own, 1, 1, scenario.ids))
    assert robot.command().report is None


def test_a_robot_that_cannot_be_where_it_is_told_to_be_does_not_know_where_it_is() -> None:
    """Else its peers would refuse what it says, and give it up."""
    far = Sense((2.0 * plausible(SCENARIO).place, 0.0), 0, 0.0, (0.0, 0.0))
    for sense, place in ((far, None), (replace(far, position=(0.1, 0.1)), (0.1, 0.1))):
        assert Robot(SCENARIO, OWN, 1).begin(Tick(OWN, 1, 0, (OWN,), sense=sense)).position == place


def test_a_life_is_over_once_its_disk_stands_or_a_newer_one_is_there() -> None:
    def has_ended(robot: int, life: int, *members: Member) -> bool:
        told = Tick(robot, life, 0, IDS, roster=Roster(1, members))
        return Robot(SCENARIO, robot, life).has_ended(told)

    live, standing = Member(1, 1, "live", 0.1), Member(2, 1, "standing", 0.1, (0.5, 0.0))
    assert not has_ended(1, 1, live, standing)
    assert has_ended(2, 1, live, standing)
    assert not has_ended(2, 2, live, standing)  # a roster from before this life
    assert has_ended(2, 1, Member(2, 2, "live", 0.1))
    assert not has_ended(2, 2, Member(2, 2, "live", 0.1))
    assert not has_ended(3, 1, Member(2, 2, "live", 0.1))
