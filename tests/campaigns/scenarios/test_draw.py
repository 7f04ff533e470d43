"""Draws: valid, the same again, and out of all that a scenario can express."""

import math
from collections import defaultdict
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from functools import cache
from itertools import pairwise
from typing import Any

import pytest

from protocol.scenario.file import validated
from protocol.scenario.model import Point, ProcessFault, Scenario
from tests.campaigns.campaign import Dice
from tests.campaigns.scenarios.draw import drawn

pytestmark = pytest.mark.slow

MANY = 600


@cache
def draws() -> list[Scenario]:
    """Many, the same for all tests."""
    return [scenario for seed in range(MANY) if (scenario := drawn(Dice(seed))) is not None]


def test_draws_are_valid_with_the_filter_on_and_k_a_number() -> None:
    for scenario in draws():
        assert validated(scenario) == scenario
        assert scenario.control.filter == "separating-lines"
        assert scenario.k > 0.0


def test_few_draws_are_refused() -> None:
    assert len(draws()) > 0.95 * MANY


def _said(value: Any, found: dict[str, set[str]]) -> None:
    """Every value of every field of a scenario and all that it is made of."""
    if is_dataclass(value):
        for field in fields(value):
            inner = getattr(value, field.name)
            found[f"{type(value).__name__}.{field.name}"].add(repr(inner))
            _said(inner, found)
    elif isinstance(value, tuple):
        for each in value:
            _said(each, found)


FIXED = {  # of scenarios that are drawn: plants, maps, names, and what only other campaigns are about
    *("Scenario.name", "Scenario.description", "Scenario.map", "Scenario.world", "Scenario.base"),
    *("World.plant", "World.lease", "Control.filter", "Control.turn", "Control.lifetime", "Time.endless"),
    *("Link.capacity", "Link.burst", "Link.roaming", "Link.distance", "Link.preset"),
    *("RobotSpec.base", "Journey.within"),
}


def test_every_field_is_drawn() -> None:
    found: dict[str, set[str]] = defaultdict(set)
    for scenario in draws():
        _said(scenario, found)
    assert {name for name, values in found.items() if len(values) == 1} <= FIXED


def _events(scenario: Scenario, event: str) -> list[ProcessFault]:
    return [fault for fault in scenario.process if fault.event == event]


def _late(scenario: Scenario) -> bool:
    """A robot is killed at 0 and started later, and another one is restarted in between."""
    return any(
        killed.at == 0.0 and up.robot == killed.robot and other.robot != up.robot and other.at < up.at
        for killed in _events(scenario, "kill")
        for up in _events(scenario, "restart")
        for other in _events(scenario, "restart")
    )


def _smallest_gap(scenario: Scenario) -> float:
    """Between starts, and to the boundary, in radii."""
    gaps = [
        (-scenario.workspace.shape.distance(*one.start) - one.radius) / one.radius for one in scenario.robots
    ]
    return min(
        gaps
        + [
            (math.dist(one.start, other.start) - one.radius - other.radius) / one.radius
            for one in scenario.robots
            for other in scenario.robots
            if one.id < other.id
        ]
    )


def _sharpest(corners: tuple[Point, ...] | None) -> float:
    """The smallest angle of a polygon, rad."""
    if corners is None:
        return math.pi
    directions = [math.atan2(v - y, u - x) for (x, y), (u, v) in pairwise((*corners, corners[0]))]
    turns = [abs(math.remainder(b - a, math.tau)) for a, b in pairwise((*directions, directions[0]))]
    return math.pi - max(turns)


EXPRESSED: dict[str, Callable[[Scenario], object]] = {
    "a late first life, and a restart before it": _late,
    "parts, a kill and orders": lambda s: s.parts and s.orders and _events(s, "kill"),
    "ids with gaps": lambda s: s.ids != tuple(range(1, len(s.robots) + 1)),
    "paused from tick 0": lambda s: any(fault.at == 0.0 for fault in _events(s, "pause")),
    "overlapping partitions": lambda s: any(
        one.from_ < other.until and other.from_ < one.until
        for i, one in enumerate(s.link.partition)
        for other in s.link.partition[:i]
    ),
    "a delay as long as the run": lambda s: (
        max((s.link.delay,) if isinstance(s.link.delay, float) else s.link.delay) > 0.9 * s.time.limit
    ),
    "noise as large as a robot": lambda s: max(e.bound for e in s.sensing) > 0.3 * s.robots[0].radius,
    "starts that all but touch": lambda s: 0.0 <= _smallest_gap(s) < 1e-12,
    "acute corners": lambda s: _sharpest(s.workspace.points) < 0.6,
    "a room that touches a robot": lambda s: s.workspace.points and 0.0 < _smallest_gap(s) < 1e-4,
    "a room far from the origin": lambda s: s.workspace.shape.around.x > 300.0,
    "radii a hundred to one": lambda s: (
        max(r.radius for r in s.robots) > 100 * min(r.radius for r in s.robots)
    ),
    "guests that fail": lambda s: any(fault.robot not in s.ids for fault in s.process),
    "robots that leave and come back": lambda s: any(spec.id in s.ids for spec in s.newcomers),
    "a halt and its release": lambda s: {True, False} <= {order.halt for order in s.orders},
    "adversary": lambda s: s.control.law.endswith(":Adversary"),
}


def test_orders_of_events_and_extremes_are_drawn() -> None:
    assert [feature for feature, shows in EXPRESSED.items() if not any(map(shows, draws()))] == []
