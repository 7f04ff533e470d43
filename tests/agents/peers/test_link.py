"""Injected link faults: delay, repetition and loss of States, and radio ranges."""

from dataclasses import replace
from itertools import groupby

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.peers.link import Radio, StateLink
from agents.peers.state import PeerState
from protocol.scenario.model import RobotSpec, Scenario
from protocol.scenario.network import Burst, Distance, Partition, Roaming
from protocol.scenario.network import Link as LinkFaults

ROBOTS = tuple(RobotSpec(i, 0.01, (0.05 * i, 0.0), (0.05 * i, 0.1)) for i in (1, 2, 3, 4))
SCENARIO = Scenario(robots=ROBOTS, seed=5)
LINK = LinkFaults(burst=Burst(good=2.0, bad=0.5), roaming=Roaming(10.0, (0.5, 1.5)))
WIRELESS = replace(SCENARIO, robots=ROBOTS[:2], link=LINK)
TICKS = range(24_000)


def test_bad_times_are_as_long_and_as_frequent_as_stated() -> None:
    radio = Radio(WIRELESS, 1)
    lengths: dict[bool, list[int]] = {True: [], False: []}
    for bad, ticks in groupby(radio.is_bad(tick) for tick in TICKS):
        lengths[bad].append(len(list(ticks)))
    step = WIRELESS.time.step
    assert step * sum(lengths[True]) / len(lengths[True]) == pytest.approx(0.5, rel=0.1)
    assert step * sum(lengths[False]) / len(lengths[False]) == pytest.approx(2.0, rel=0.1)


def test_there_is_one_gap_in_each_interval() -> None:
    radio = Radio(WIRELESS, 1)
    away = [radio.back(tick) > tick for tick in TICKS]
    gaps = [len(list(ticks)) for is_away, ticks in groupby(away) if is_away]
    assert len(gaps) == pytest.approx(len(TICKS) / 200, rel=0.05)
    assert all(radio.back(tick) == tick or not away[radio.back(tick)] for tick in TICKS[:-100])
    assert sum(away) / len(TICKS) == pytest.approx(0.1, rel=0.15)


@given(st.integers(0, 2**63 - 1), st.lists(st.integers(0, 3000), min_size=1, max_size=30))
def test_what_a_radio_does_does_not_depend_on_what_was_asked_before(seed: int, ticks: list[int]) -> None:
    scenario = replace(WIRELESS, seed=seed)
    one = Radio(scenario, 2)
    for tick in ticks:
        fresh = Radio(scenario, 2)
        assert (one.is_bad(tick), one.back(tick), one.slot(tick)) == (
            fresh.is_bad(tick),
            fresh.back(tick),
            fresh.slot(tick),
        )


def state(robot: int, tick: int, incarnation: int = 1) -> PeerState:
    return PeerState(robot, incarnation, tick, True, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, radius=0.1)


def heard(faults: LinkFaults, states: list[PeerState], until: int = 200) -> list[list[tuple[int, int]]]:
    """What robot 1 hears at each tick, as (robot, tick of the State)."""
    link = StateLink(replace(SCENARIO, link=faults), 1)
    for each in states:
        link.put(each)
    return [[(s.robot, s.tick) for s in link.take(tick)] for tick in range(until)]


def test_only_a_state_of_the_tick_or_a_later_one_is_ahead() -> None:
    link = StateLink(SCENARIO, 1)
    for each in (state(2, 3), state(3, 4), state(4, 5)):
        link.put(each)
    assert list(link.ahead(4)) == [3, 4]


def test_a_delay_takes_effect_at_the_first_tick_at_or_after_it() -> None:
    assert heard(LinkFaults(delay=0.11), [state(2, 0)])[3] == [(2, 0)]
    assert heard(LinkFaults(delay=0.10), [state(2, 0)])[2] == [(2, 0)]


@pytest.mark.slow
def test_loss_and_duplication_happen_as_often_as_stated() -> None:
    states = [state(2, tick) for tick in range(1600)]
    lost = heard(LinkFaults(loss=0.3), states, 1600)
    assert 0.65 < sum(map(len, lost)) / 1600 < 0.75
    doubled = heard(LinkFaults(duplicate=0.2, delay=(0.0, 0.2)), states, 1700)
    assert 1.15 < sum(map(len, doubled)) / 1600 < 1.25


def test_a_partition_separates_groups_while_it_lasts() -> None:
    faults = LinkFaults(partition=(Partition(1.0, 2.0, ((1, 3), (2, 4))),))
    states = [state(robot, tick) for tick in (19, 20, 39, 40) for robot in (2, 3)]
    assert [entry for tick in heard(faults, states) for entry in tick] == [
        (2, 19), (3, 19), (3, 20), (3, 39), (2, 40), (3, 40),
    ]  # fmt: skip


@given(st.randoms(use_true_random=False), st.integers(0, 2**63 - 1))
def test_the_order_of_arrival_changes_nothing(random, seed: int) -> None:
    wireless = {"capacity": 70.0, "burst": Burst(1.0, 1.0, 0.1, 0.3), "roaming": Roaming(2.0, 0.5)}
    faults = LinkFaults(
        delay=(0.0, 1.0), jitter=0.3, loss=0.3, duplicate=0.3, **(wireless if seed % 2 else {})
    )
    states = [state(robot, tick) for tick in range(20) for robot in (2, 3, 4)]
    shuffled = states.copy()
    random.shuffle(shuffled)
    scenario = replace(SCENARIO, link=faults, seed=seed)

    def timeline(order: list[PeerState]) -> list[list[PeerState]]:
        link = StateLink(scenario, 1)
        for each in order:
            link.put(each)
        return [link.take(tick) for tick in range(60)]

    assert timeline(states) == timeline(shuffled)


@pytest.mark.slow
def test_a_burst_of_either_radio_holds_up_and_loses_what_passes_it() -> None:
    burst = Burst(good=1.0, bad=1.0, delay=0.5, loss=0.5)
    link = StateLink(replace(SCENARIO, link=LinkFaults(burst=burst)), 1)
    for tick in range(3000):
        link.put(state(2, tick))
    delays = [tick - each.tick for tick in range(3100) for each in link.take(tick)]
    assert {*delays} == {0, 10, 20}  # bad are none, one and both, each half of the time
    assert delays.count(0) / 3000 == pytest.approx(0.25, abs=0.06)
    assert delays.count(10) / 3000 == pytest.approx(0.5 * 0.5, abs=0.06)
    assert delays.count(20) / 3000 == pytest.approx(0.25 * 0.25, abs=0.04)
    assert link.lost == 3000 - len(delays)


def test_states_wait_for_the_end_of_a_gap_of_sender_or_receiver() -> None:
    scenario = replace(SCENARIO, link=LinkFaults(roaming=Roaming(10.0, 1.0)))
    link, radios = StateLink(scenario, 1), [Radio(scenario, robot) for robot in (1, 2)]
    for tick in range(1000):
        link.put(state(2, tick))
    found = {each.tick: tick for tick in range(1200) for each in link.take(tick)}
    for tick in range(1000):
        assert found[tick] == radios[0].back(radios[1].back(tick))
    assert link.lost == 0


def test_a_medium_carries_as_many_states_as_stated_in_turns() -> None:
    """40 per second are two a tick: of three peers and the robot itself, half of all States."""
    link = StateLink(replace(SCENARIO, link=LinkFaults(capacity=40.0)), 1)
    for tick in range(1000):
        for robot in (2, 3, 4):
            link.put(state(robot, tick))
    delays = [(each.robot, tick - each.tick) for tick in range(1100) for each in link.take(tick)]
    assert {delay for _, delay in delays} == {1}  # 25 ms or 50 ms
    for robot in (2, 3, 4):
        assert sum(each == robot for each, _ in delays) == pytest.approx(500, abs=60)


def test_delay_and_loss_grow_with_the_distance() -> None:
    faults = LinkFaults(distance=Distance(free=1.0, delay=0.05, loss=0.2))
    for metres, share in ((1, 1.0), (3, 0.6), (5, 0.2)):
        link, delays = StateLink(replace(SCENARIO, link=faults), 1), []
        for tick in range(2000):
            link.locate(tick, (float(metres), 0.0))
            link.put(state(2, tick))
            delays += [tick - each.tick for each in link.take(tick)]
        assert {*delays} == {metres - 1}
        assert len(delays) / 2000 == pytest.approx(share, abs=0.05)


def test_a_state_that_is_said_again_meets_the_same_faults() -> None:
    faults = LinkFaults(delay=(0.0, 0.3), loss=0.3, duplicate=0.2)
    states = [state(2, tick) for tick in range(200)]
    once, again = heard(faults, states), heard(faults, [each for each in states for _ in range(3)])
    assert [set(each) for each in again] == [set(each) for each in once]
