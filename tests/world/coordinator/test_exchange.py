"""Commands that are executed, robots that keep others waiting, and the States received in a large fleet."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.peers.far import SummaryPlaces
from protocol.crowd import LEAD, period
from protocol.errors import MessageError
from protocol.messages import Command, Sense, Summary, Vector
from protocol.scenario.body import Body
from protocol.scenario.model import Scenario
from protocol.scenario.network import Network
from tests.world.driving import advance, joined, obeying, scenario, two
from world.coordinator.exchange import Interest, blamed, runs
from world.report import result_of

robots = st.frozensets(st.integers(1, 8), min_size=1)


def among(active: frozenset[int]) -> dict[int, int]:
    return dict.fromkeys(sorted(active), len(active))


@given(robots, robots, st.dictionaries(st.integers(1, 9), st.lists(st.integers(1, 9))))
def test_a_robot_that_takes_part_is_blamed(
    active: frozenset[int], waiting: frozenset[int], missing: dict[int, list[int]]
) -> None:
    waiting &= active
    found = blamed(among(active), waiting, missing)
    assert found.keys() <= active
    assert bool(found) == bool(waiting)
    assert all(found.values())


@given(robots.filter(lambda each: len(each) > 2), st.data())
def test_one_faulty_robot_never_costs_another(active: frozenset[int], data: st.DataObject) -> None:
    """It says what it likes, or nothing; the others are well and lack its State, or nothing."""
    faulty = data.draw(st.sampled_from(sorted(active)))
    well = active - {faulty}
    heard = data.draw(st.booleans())
    missing = {} if heard else dict.fromkeys(well, (faulty,))
    waiting = set() if heard else set(well)
    if data.draw(st.booleans()):
        waiting.add(faulty)
        missing[faulty] = tuple(data.draw(st.lists(st.sampled_from(sorted(well)))))
    if waiting:
        assert blamed(among(active), waiting, missing).keys() == {faulty}


def test_only_those_count_that_receive_its_states() -> None:
    """Of five, three are near robot 2, and two lack its State."""
    missing: dict[int, tuple[int, ...]] = {1: (2,), 3: (2,)}
    why = "sends no State that its peers accept: 2 of 3 lack it"
    assert blamed({1: 2, 2: 4, 3: 2, 4: 2, 5: 1}, {1, 3}, missing) == {2: why}


@pytest.mark.parametrize(("lacks", "names"), [((4, 2), "2, 4"), ((5, 1, 3, 4, 2), "1, 2, 3 and 2 more")])
def test_one_that_lacks_states_that_the_others_receive_is_blamed(lacks: tuple[int, ...], names: str) -> None:
    found = blamed(among(frozenset(range(1, 10))), {9}, {9: lacks})
    assert found == {9: f"lacks the State of robot {names}"}


def test_a_complaint_is_no_command() -> None:
    world = joined(two())
    world.open_tick()
    assert not world.accept(Command(1, 1, 0, (0.1, 0.0), roster=0, awaits=(2,)))
    assert world.exchange.waiting == {1, 2}
    assert world.exchange.blamed().keys() == {2}
    assert world.accept(Command(1, 1, 0, (0.1, 0.0)))
    world.close_tick()
    assert world.truth.positions[0][0] > -0.1


def test_commands_are_refused_by_reason() -> None:
    world = joined(two())
    assert not world.accept(Command(1, 1, 0, (0.1, 0.0)))  # not open yet
    advance(world)
    world.open_tick()
    refused = [
        Command(1, 1, 0, (0.1, 0.0)),
        Command(1, 1, 2, (0.1, 0.0)),
        Command(1, 2, 1, (0.1, 0.0)),
        Command(3, 1, 1, (0.1, 0.0)),
    ]
    assert not any(world.accept(command) for command in refused)
    assert world.accept(Command(1, 1, 1, (0.0, 0.0)))
    assert not world.accept(Command(1, 1, 1, (0.1, 0.0)))
    world.lost(2)
    assert not world.accept(Command(2, 1, 1, (0.1, 0.0)))
    world.close_tick()
    assert world.open_tick()
    world.close_tick()
    assert world.open_tick()
    assert not world.accept(Command(1, 1, 2, (0.1, 0.0)))  # of the tick that it has missed
    assert world.truth.positions == ((-0.1, 0.1), (-0.1, -0.1))
    assert result_of(world)["rejected_commands"] == {
        **{"early": 2, "late": 2, "incarnation": 1},
        **{"unknown": 1, "duplicate": 1, "inactive": 1},
    }


RADIUS = 0.01


def four(reach: float = 0.05) -> Scenario:
    robots = [((0.1 * n, 0.0), (0.1 * n, 0.1)) for n in range(-2, 2)]
    return scenario(*robots, radius=RADIUS, network=Network("near", reach))


def sensed(at: list[Vector]) -> dict[int, Sense]:
    return {robot: Sense(place, 0, 0.0, (0.0, 0.0)) for robot, place in enumerate(at, 1)}


def nowhere(robot: int) -> Vector | None:  # noqa: ARG001  # no orders
    return None


def test_a_peer_is_heard_once_there_was_time_to_subscribe_to_it() -> None:
    interest, active = Interest(four()), frozenset((1, 2, 3, 4))
    heard = [interest.heard(2, 1, tick, (1, 3), active) for tick in range(LEAD + 1)]
    assert heard == [(2,)] * LEAD + [(1, 2, 3)]
    assert interest.heard(2, 1, LEAD + 1, (3, 4), active) == (2, 3)
    assert interest.heard(2, 1, LEAD + 2, (3, 4), frozenset((2, 4))) == (2,)
    assert interest.heard(2, 2, LEAD + 3, (3, 4), active) == (2,)  # another life


def test_the_summary_says_where_everybody_was_sensed() -> None:
    setting = four()
    interest = Interest(setting)
    at = [(0.01 * n, 0.02) for n in range(4)]
    interest.open(0, setting, sensed(at), nowhere)
    for tick in range(1, period(setting)):
        interest.open(tick, setting, sensed([(0.2, 0.2)] * 4), nowhere)
        interest.open(tick, setting, {1: Sense(None, tick, 0.0, (0.0, 0.0))}, nowhere)
    assert interest.places[1] == (0.2, 0.2)
    assert interest.summary.tick == 0
    assert interest.summary.robots == runs((1, 2, 3, 4))
    assert np.allclose(np.frombuffer(interest.summary.positions, "<f4").reshape(-1, 2), at)
    away = [math.dist(place, spec.goal) ** 2 for place, spec in zip(at, setting.robots, strict=True)]
    assert np.allclose(np.frombuffer(interest.summary.gammas, "<f4"), away)
    interest.open(0, setting, sensed(at), {1: at[0]}.get)
    assert np.allclose(np.frombuffer(interest.summary.gammas, "<f4"), [0.0, *away[1:]])


@pytest.mark.parametrize("moves", [0.0, 0.2])  # m/s as its process dies: at rest, or not before some ticks
def test_a_later_life_awaits_only_peers_that_its_grants_name(moves: float) -> None:
    """Its ledger entry is that of the life before until the disk is certainly static."""
    setting = replace(four(1.0), body=Body("omnidirectional", speed=0.5, acceleration=0.5, hold=0.1))
    world = joined(setting)
    named: dict[int, set[int]] = {}  # by tick
    for _ in range(5):
        advance(world, {4: (0.0, moves)})
    assert world.lost(4)
    world.join(4)
    while world.tick < 5 + 6 * LEAD:
        told = world.open_tick()[4]
        assert told.heard is None  # which only external bases need
        named[world.tick] = {each.peer for each in told.grants.bindings} if told.grants else set()
        early = {peer for tick, peers in named.items() if tick + LEAD <= world.tick for peer in peers}
        assert {*told.active} <= {4} | early
        advance(world)
    assert len(told.active) > 1


@given(st.sets(st.integers(1, 12), min_size=1))
def test_runs_stand_for_the_ids_that_they_are_made_of(ids: set[int]) -> None:
    assert runs([1, 2, 3, 7]) == np.array([1, 3, 7, 1], "<u4").tobytes()
    flat = np.zeros(len(ids), dtype="<f4").tobytes()
    assert SummaryPlaces(Summary(0, runs(sorted(ids)), 2 * flat, flat, flat)).robots.tolist() == sorted(ids)


@pytest.mark.parametrize("told", [(2, 2, 3, 1), (4, 1, 2, 2), (1, 2**32 - 1), (1, 4), (1, 1)])
def test_runs_that_cannot_be_are_refused(told: tuple[int, ...]) -> None:
    made = np.array(told, dtype="<u4").tobytes()
    with pytest.raises(MessageError):
        SummaryPlaces(Summary(0, made, bytes(24), bytes(12), bytes(12)))


def test_a_summary_has_the_slices_as_last_commanded_and_else_the_attraction() -> None:
    world = joined(four(1.0))
    told = world.open_tick()
    for robot, each in told.items():
        assert world.accept(obeying(each, slice=0.75 if robot == 3 else None))
    world.close_tick()
    while world.exchange.summary.tick == 0:
        advance(world)  # says nothing of it, so that it stays
        world.open_tick()
    gammas = np.frombuffer(world.exchange.summary.gammas, dtype="<f4")
    attraction = (2.0 * np.sqrt(gammas)).tolist()
    slices = np.frombuffer(world.exchange.summary.slices, dtype="<f4").tolist()
    assert slices == pytest.approx([*attraction[:2], 0.75, attraction[3]])


SIGNALLING = np.full(1, 0x7FA00001, "<u4").tobytes()  # NaN of which a conversion would warn


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    "slices",
    [bytes(8), np.full(1, -1.0, "<f4").tobytes(), np.full(1, np.nan, "<f4").tobytes(), SIGNALLING],
)
def test_slices_that_are_no_norms_are_refused(slices: bytes) -> None:
    with pytest.raises(MessageError):
        SummaryPlaces(Summary(0, runs([1]), bytes(8), bytes(4), slices))
