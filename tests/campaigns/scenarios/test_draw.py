"""Draws: valid, the same again, and out of all that a scenario can express."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from itertools import pairwise

import pytest

from protocol.scenario.body import PRESETS
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


def test_a_seed_gives_the_same() -> None:
    assert drawn(Dice(MANY)) == drawn(Dice(MANY)) != drawn(Dice(MANY + 1))


def test_few_draws_are_refused() -> None:
    assert len(draws()) > 0.95 * MANY


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
    "a part larger than a robot": lambda s: any(p.radius > s.robots[0].radius for p in s.parts),
    "parts, a kill and orders": lambda s: s.parts and s.orders and _events(s, "kill"),
    "one robot": lambda s: len(s.robots) == 1,
    "eight robots": lambda s: len(s.robots) == 8,
    "more": lambda s: len(s.robots) > 8,
    "ids with gaps": lambda s: s.ids != tuple(range(1, len(s.robots) + 1)),
    "a late first life, and a restart before it": _late,
    "a restart at tick 1": lambda s: any(s.ticks(fault.at) == 1 for fault in _events(s, "restart")),
    "three restarts": lambda s: len(_events(s, "restart")) > 2,
    "both ends restarted": lambda s: len({fault.robot for fault in _events(s, "restart")}) > 1,
    "paused from tick 0": lambda s: any(fault.at == 0.0 for fault in _events(s, "pause")),
    "resumed": lambda s: _events(s, "resume"),
    "killed for good": lambda s: s.process and s.process[-1].event == "kill",
    "three partitions": lambda s: len(s.link.partition) > 2,
    "overlapping partitions": lambda s: any(
        one.from_ < other.until and other.from_ < one.until
        for i, one in enumerate(s.link.partition)
        for other in s.link.partition[:i]
    ),
    "a delay as long as the run": lambda s: (
        max((s.link.delay,) if isinstance(s.link.delay, float) else s.link.delay) > 0.9 * s.time.limit
    ),  # type: ignore[type-var]
    "jitter": lambda s: s.link.jitter > 10.0 * s.time.step,
    "nearly all lost": lambda s: s.link.loss > 0.95,
    "duplicates": lambda s: s.link.duplicate > 0.5,
    "noise as large as a robot": lambda s: max(e.bound for e in s.sensing) > 0.3 * s.robots[0].radius,
    "bias": lambda s: any(math.hypot(*entry.bias) > 0.0 for entry in s.sensing),
    "sensing of its own for a robot": lambda s: any(entry.robots for entry in s.sensing),
    "late measurements": lambda s: any(entry.delay for entry in s.sensing),
    "missing measurements": lambda s: any(entry.dropout > 0.5 for entry in s.sensing),
    "inexact motors": lambda s: s.actuation.noise == 0.3,
    "a short period": lambda s: s.time.step < 0.006,
    "a long period": lambda s: s.time.step > 0.5,
    "centimetres": lambda s: (s.workspace.radius or 1.0) < 0.02,
    "hundreds of metres": lambda s: (s.workspace.radius or 1.0) > 100.0,
    "unequal radii": lambda s: max(r.radius for r in s.robots) > 3.0 * min(r.radius for r in s.robots),
    "density 0.4": lambda s: sum(r.radius**2 for r in s.robots) > 0.399 * (s.workspace.radius or 1.0) ** 2,
    "straight walls": lambda s: s.workspace.points is not None,
    "obstacles": lambda s: len(s.obstacles) > 2,
    "polygons": lambda s: any(obstacle.points for obstacle in s.obstacles),
    "starts that all but touch": lambda s: 0.0 <= _smallest_gap(s) < 1e-12,
    "starts a micrometre apart": lambda s: 1e-8 < _smallest_gap(s) < 1e-5,
    "acute corners": lambda s: _sharpest(s.workspace.points) < 0.6,
    "a room that touches a robot": lambda s: s.workspace.points and 0.0 < _smallest_gap(s) < 1e-4,
    "a room far from the origin": lambda s: s.workspace.shape.around.x > 300.0,
    "radii a hundred to one": lambda s: (
        max(r.radius for r in s.robots) > 100 * min(r.radius for r in s.robots)
    ),
    "presets": lambda s: s.body in PRESETS and s.body != "point",
    "bodies of its own for a robot": lambda s: any(spec.body is not None for spec in s.robots),
    "wheels": lambda s: any(s.body_of(robot).kind == "differential-drive" for robot in s.ids),
    "bodies that hold on": lambda s: s.body_of(s.ids[0]).hold > 3.0 * s.time.step,
    "slipping": lambda s: s.body_of(s.ids[0]).odometry > 0.0,
    "directions that are off": lambda s: any(entry.heading > 0.01 for entry in s.sensing),
    "reciprocal": lambda s: s.control.law == "reciprocal",
    "near peers only": lambda s: s.hears_near and s.network.reach and s.network.reach < s.robots[0].radius,
    "goals": lambda s: any(order.goal for order in s.orders),
    "guests": lambda s: any(spec.id not in s.ids for spec in s.newcomers),
    "guests that fail": lambda s: any(fault.robot not in s.ids for fault in s.process),
    "robots that leave and come back": lambda s: any(spec.id in s.ids for spec in s.newcomers),
    "obstacles that come": lambda s: any(order.place for order in s.orders),
    "obstacles that go": lambda s: any(order.take for order in s.orders),
    "a halt and its release": lambda s: {True, False} <= {order.halt for order in s.orders},
    "both paces": lambda s: "pace" not in s.control.additions,
    "orca": lambda s: ":Orca" in s.control.law,
    "barrier": lambda s: ":Barrier" in s.control.law,
    "adversary": lambda s: s.control.law.endswith(":Adversary"),
    "no escape": lambda s: "escape" not in s.control.additions,
    "small k": lambda s: s.k < 2.0,
    "large k": lambda s: s.k > 3000.0,
    "a fence after a tick or two": lambda s: s.time.fence < 2.0 * s.time.step,
    "a fence after the run": lambda s: s.time.fence > s.time.limit,
    "an early deadlock": lambda s: s.time.deadlock < 0.3 * s.time.limit,
}


def test_everything_that_may_matter_is_drawn() -> None:
    assert [feature for feature, shows in EXPRESSED.items() if not any(map(shows, draws()))] == []
