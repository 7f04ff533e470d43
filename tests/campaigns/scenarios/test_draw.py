"""Draws: valid, the same again, and out of all that a scenario can express."""

from collections import defaultdict
from dataclasses import fields, is_dataclass
from functools import cache
from typing import Any

import pytest

from protocol.scenario.file import validated
from protocol.scenario.model import Scenario
from tests.campaigns.campaign import Dice
from tests.campaigns.scenarios.draw import drawn

pytestmark = pytest.mark.slow

MANY = 600


@cache
def draws() -> list[Scenario]:
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
