"""Commands: which are executed, and which robots keep the others waiting."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from protocol.messages import Command
from tests.world.driving import advance, joined, two
from world.coordinator.exchange import blamed
from world.report import result_of

robots = st.frozensets(st.integers(1, 8), min_size=1)


def among(active: frozenset[int]) -> dict[int, int]:
    """Every robot receives all States."""
    return dict.fromkeys(sorted(active), len(active))


@given(robots, robots, st.dictionaries(st.integers(1, 9), st.lists(st.integers(1, 9))))
def test_a_robot_that_takes_part_is_blamed(
    active: frozenset[int], waiting: frozenset[int], lacking: dict[int, list[int]]
) -> None:
    waiting &= active
    found = blamed(among(active), waiting, lacking)
    assert found.keys() <= active
    assert bool(found) == bool(waiting)
    assert all(found.values())


@given(robots.filter(lambda each: len(each) > 2), st.data())
def test_one_faulty_robot_never_costs_another(active: frozenset[int], data: st.DataObject) -> None:
    """It says what it likes, or nothing; the others are well and lack its State, or nothing."""
    faulty = data.draw(st.sampled_from(sorted(active)))
    well = active - {faulty}
    heard = data.draw(st.booleans())
    lacking = {} if heard else dict.fromkeys(well, (faulty,))
    waiting = set() if heard else set(well)
    if data.draw(st.booleans()):
        waiting.add(faulty)
        lacking[faulty] = tuple(data.draw(st.lists(st.sampled_from(sorted(well)))))
    if waiting:
        assert blamed(among(active), waiting, lacking).keys() == {faulty}


def test_only_those_count_that_receive_its_states() -> None:
    """Of four, two are near robot 2, and both lack its State."""
    lacking: dict[int, tuple[int, ...]] = {1: (2,), 3: (2,)}
    assert blamed({1: 2, 2: 3, 3: 2, 4: 1}, {1, 3}, lacking).keys() == {2}


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
    assert world.truth.positions == ((-0.1, 0.1), (-0.1, -0.1))
    assert result_of(world)["rejected_commands"] == {
        **{"early": 2, "late": 1, "incarnation": 1},
        **{"unknown": 1, "duplicate": 1, "inactive": 1},
    }
