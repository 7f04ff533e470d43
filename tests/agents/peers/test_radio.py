"""The radio of a robot: how long it is bad and away, the same whenever and in whatever order it is asked."""

from __future__ import annotations

from dataclasses import replace
from itertools import groupby

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.peers.radio import Radio
from protocol.scenario.model import RobotSpec, Scenario
from protocol.scenario.network import Burst, Link, Roaming

ROBOTS = tuple(RobotSpec(i, 0.01, (0.05 * i, 0.0), (0.05 * i, 0.1)) for i in (1, 2))
LINK = Link(burst=Burst(good=2.0, bad=0.5), roaming=Roaming(10.0, (0.5, 1.5)))
SCENARIO = Scenario(robots=ROBOTS, seed=5, link=LINK)
TICKS = range(60_000)


def test_bad_times_are_as_long_and_as_frequent_as_stated() -> None:
    radio = Radio(SCENARIO, 1)
    lengths: dict[bool, list[int]] = {True: [], False: []}
    for bad, ticks in groupby(radio.is_bad(tick) for tick in TICKS):
        lengths[bad].append(len(list(ticks)))
    step = SCENARIO.time.step
    assert step * sum(lengths[True]) / len(lengths[True]) == pytest.approx(0.5, rel=0.1)
    assert step * sum(lengths[False]) / len(lengths[False]) == pytest.approx(2.0, rel=0.1)


def test_there_is_one_gap_in_each_interval() -> None:
    radio = Radio(SCENARIO, 1)
    away = [radio.back(tick) > tick for tick in TICKS]
    gaps = [len(list(ticks)) for is_away, ticks in groupby(away) if is_away]
    assert len(gaps) == pytest.approx(len(TICKS) / 200, rel=0.05)
    assert all(radio.back(tick) == tick or not away[radio.back(tick)] for tick in TICKS[:-100])
    assert sum(away) / len(TICKS) == pytest.approx(0.1, rel=0.15)


@given(st.integers(0, 2**63 - 1), st.lists(st.integers(0, 3000), min_size=1, max_size=30))
def test_what_a_radio_does_does_not_depend_on_what_was_asked_before(seed: int, ticks: list[int]) -> None:
    scenario = replace(SCENARIO, seed=seed)
    one = Radio(scenario, 2)
    for tick in ticks:
        fresh = Radio(scenario, 2)
        assert (one.is_bad(tick), one.back(tick), one.turn(tick)) == (
            fresh.is_bad(tick),
            fresh.back(tick),
            fresh.turn(tick),
        )


def test_robots_have_radios_of_their_own() -> None:
    one, other = Radio(SCENARIO, 1), Radio(SCENARIO, 2)
    assert [one.is_bad(tick) for tick in TICKS[:1000]] != [other.is_bad(tick) for tick in TICKS[:1000]]
    assert Radio(replace(SCENARIO, link=Link()), 1).back(17) == 17
