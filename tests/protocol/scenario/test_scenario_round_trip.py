"""Any valid scenario survives a file, and any junk in one is refused in order."""

from __future__ import annotations

import math
from dataclasses import fields
from typing import Any

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from protocol.errors import ScenarioError
from protocol.scenario.body import Actuation, Base
from protocol.scenario.file import document_of, parse_document, parse_toml, write_toml
from protocol.scenario.model import (
    ADDITIONS,
    Carrying,
    Control,
    Obstacle,
    Order,
    Part,
    ProcessFault,
    RobotSpec,
    Scenario,
    Sensing,
    Time,
    Workspace,
    World,
)
from protocol.scenario.network import Burst, Distance, Link, Network, Partition, Roaming

positive = st.floats(1e-9, 1e6)
nonnegative = st.floats(0, 1e6)
shares = st.floats(0, 1)
spans = nonnegative | st.tuples(nonnegative, nonnegative).map(lambda pair: (min(pair), max(pair)))
points = st.tuples(st.floats(-1e5, 1e5), st.floats(-1e5, 1e5))
texts = st.text(st.characters(exclude_categories=["C", "Z"]) | st.just(" "), max_size=20)
IDS = (1, 7, 30)
some_ids = st.lists(st.sampled_from(IDS), min_size=1, unique=True).map(tuple)
partitions = st.builds(
    Partition,
    st.floats(0, 100),
    st.floats(101, 200),
    st.sampled_from([(), ((1,),), ((1, 7), (30,)), ((), (30, 1))]),
)


@st.composite
def scenarios(draw: st.DrawFn) -> Scenario:
    size = draw(st.floats(1e-3, 1e5))
    radii = [size * draw(st.floats(0.01, 0.1)) for _ in IDS]
    places = [(-0.5 * size, 0.3 * size), (0.1 * size, -0.5 * size), (0.5 * size, 0.5 * size)]
    goals = draw(st.permutations(places))
    robots = tuple(RobotSpec(*entry) for entry in zip(IDS, radii, places, goals, strict=True))
    step = draw(st.floats(1e-3, 1.0))
    laws = st.builds(
        Control,
        st.sampled_from(["gradient", "reciprocal", "docs/law.py:Mine", "laws:Orca(horizon=2.0)"]),
        positive | st.sampled_from(["auto", "certified"]),
        st.sampled_from(["separating-lines", "none"]),
        positive,
        st.lists(st.sampled_from(ADDITIONS), unique=True).map(tuple),
    )
    sensing = st.builds(
        Sensing,
        spans,
        nonnegative,
        st.none() | nonnegative,
        points,
        shares,
        st.none() | some_ids,
        contradiction=st.sampled_from(["stand", "newest"]),
    )
    faults = st.builds(ProcessFault, st.sampled_from(IDS), nonnegative, st.just("restart"))
    return Scenario(
        robots,
        draw(texts),
        draw(texts),
        draw(st.integers(0, 2**63 - 1)),
        Workspace(size),
        Time(step, draw(st.floats(1.0, 1e5)), draw(positive), draw(positive), draw(positive)),
        draw(laws),
        draw(st.lists(sensing, max_size=3).map(tuple)),
        draw(
            st.builds(
                Link,
                spans,
                nonnegative,
                shares,
                shares,
                st.lists(partitions, max_size=2).map(tuple),
                st.none() | positive,
                st.none() | st.builds(Burst, positive, positive, spans, shares),
                st.none() | st.builds(Roaming, st.just(1e6), spans),
                st.none() | st.builds(Distance, nonnegative, nonnegative, nonnegative),
                st.sampled_from((None, "good-wifi", "crowded-2.4ghz", "roaming")),
            )
        ),
        draw(st.lists(faults, max_size=3).map(tuple)),
        Actuation(draw(st.floats(0, 0.3))),
    )


def test_every_field_is_written() -> None:
    said: dict[str, Any] = {
        "name": "all",
        "description": "of them",
        "seed": 3,
        "workspace": Workspace(0.4),
        "time": Time(limit=9.0),
        "control": Control(k=7.0),
        "sensing": (Sensing(dropout=0.5),),
        "link": Link(loss=0.5),
        "network": Network("near", 0.2),
        "process": (ProcessFault(1, 1.0, "restart"),),
        "actuation": Actuation(0.1),
        "world": World("mujoco"),
        "base": Base(patience=0.05),
        "body": "e-puck",
        "obstacles": (Obstacle(center=(0.0, 0.2), radius=0.01),),
        "parts": (Part(0.01, (0.0, -0.2), (0.0, -0.3)),),
        "carrying": Carrying(0.02),
        "orders": (Order(1.0, halt=True),),
        "robots": (RobotSpec(1, 0.06, (0.0, 0.0), (0.1, 0.0)),),
    }
    assert said.keys() | {"map"} == {field.name for field in fields(Scenario)}  # it stands for `obstacles`
    plain: dict[str, Any] = {"world": World(), "body": "point", "base": None, "network": Network()}
    for otherwise in ({"parts": ()}, plain):  # not everything goes together with parts
        scenario = Scenario(**(said | otherwise))
        assert parse_toml(write_toml(scenario)) == scenario


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(scenarios())
def test_round_trip(scenario: Scenario) -> None:
    text = write_toml(scenario)
    assert parse_toml(text) == scenario
    assert write_toml(parse_toml(text)) == text


junk = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5) | st.dates(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=5,
)


@pytest.mark.slow
@settings(max_examples=100, deadline=None)
@given(scenarios(), junk, st.data())
def test_junk_anywhere_is_a_scenario_error_or_fine(scenario: Scenario, bad: Any, data: st.DataObject) -> None:
    content = document_of(scenario)
    holder: Any = content
    key: Any = data.draw(st.sampled_from(sorted(holder)))
    while isinstance(holder[key], dict | list) and holder[key] and data.draw(st.booleans()):
        holder = holder[key]
        key = data.draw(
            st.sampled_from(sorted(holder) if isinstance(holder, dict) else list(range(len(holder))))
        )
    holder[key] = bad
    try:
        accepted = parse_document(content)
    except ScenarioError as error:
        assume(error.problems)
        return
    assert all(
        math.isfinite(x) for robot in accepted.robots for x in (*robot.start, *robot.goal, robot.radius)
    )
