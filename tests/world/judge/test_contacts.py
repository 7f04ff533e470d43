import math

import pytest

from protocol.scenario.model import Control
from tests.world.driving import advance, joined, scenario
from world.judge.record import TOUCH
from world.report import result_of

FAST = Control(k=60.0, speed=10.0)


def passing(y):
    """Robot 1 passes robot 2, which stands at the origin, at distance y, in four ticks."""
    return scenario(((-0.18, y), (0.2, y)), ((0.0, 0.0), (0.0, 0.1)), control=FAST)


def test_one_passage_over_several_ticks_is_one_contact_with_exact_times():
    world = joined(passing(0.05))
    for _ in range(4):
        advance(world, {1: (2.0, 0.0)})
    (contact,) = result_of(world)["contacts"]
    half = math.sqrt((0.08 - TOUCH) ** 2 - 0.05**2)
    assert contact["pair"] == [1, 2]
    assert contact["from"] == pytest.approx((0.18 - half) / 2.0, abs=1e-9)
    assert contact["until"] == pytest.approx((0.18 + half) / 2.0, abs=1e-9)
    assert contact["deepest"] == pytest.approx(0.05 - 0.08)
    assert result_of(world)["min_clearance"] == contact["deepest"]


def test_coming_back_is_a_second_contact():
    world = joined(passing(0.05))
    for velocity in (2.0, 2.0, 2.0, 2.0, -2.0, -2.0, -2.0, -2.0):
        advance(world, {1: (velocity, 0.0)})
    assert result_of(world)["collisions"] == 2


@pytest.mark.parametrize(("distance", "contacts"), [(0.08, 0), (0.08 - 0.5e-9, 0), (0.08 - 2e-9, 1)])
def test_an_exact_touch_is_no_contact(distance, contacts):
    world = joined(passing(distance))
    for _ in range(4):
        advance(world, {1: (2.0, 0.0)})
    assert result_of(world)["collisions"] == contacts


def test_leaving_the_workspace_and_coming_back():
    """Out in one tick and in again in the next is one contact."""
    world = joined(scenario(((0.2, 0.0), (0.0, 0.0)), control=FAST))
    advance(world, {1: (2.0, 0.0)})
    advance(world, {1: (-2.0, 0.0)})
    (contact,) = result_of(world)["contacts"]
    assert contact["pair"] == [0, 1]
    assert contact["from"] == pytest.approx(0.03, abs=1e-8)
    assert contact["until"] == pytest.approx(0.07, abs=1e-8)
    assert contact["deepest"] == pytest.approx(0.26 - 0.3)


def test_crossing_the_workspace_from_outside_to_outside_ends_one_contact_and_begins_another():
    world = joined(scenario(((0.2, 0.0), (0.0, 0.0)), control=Control(k=60.0, speed=20.0)))
    advance(world, {1: (2.0, 0.0)})
    advance(world, {1: (-12.0, 0.0)})
    first, second = result_of(world)["contacts"]
    assert first["until"] == pytest.approx(0.05 + 0.04 / 12.0, abs=1e-8)
    assert second["from"] == pytest.approx(0.05 + 0.56 / 12.0, abs=1e-8)
    assert second["until"] == pytest.approx(0.1)
