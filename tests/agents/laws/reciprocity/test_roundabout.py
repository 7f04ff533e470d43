"""A circle that has room for all who meet, and the way that touches it."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.laws.reciprocity.encounters import Encounter
from agents.laws.reciprocity.roundabout import (
    STEEPEST,
    WIDE,
    Roundabout,
    roundabout,
    together,
)

RADIUS, FAR = 0.03, 0.4


def _swap(count: int, heard: int) -> list[Encounter]:
    """Whom the robot at (-FAR, 0) meets of `count` on a circle, if it hears `heard` on each side."""
    met = []
    for index in [*range(1, heard + 1), *range(-heard, 0)]:
        angle = math.pi + 2.0 * math.pi * index / count
        met.append(Encounter(FAR * math.cos(angle), FAR * math.sin(angle), RADIUS, FAR))
    return met


@given(count=st.integers(5, 60), part=st.floats(0.1, 1.0))
def test_all_who_meet_have_room_on_the_circle_although_few_are_heard(count: int, part: float) -> None:
    heard = max(1, int(part * ((count - 1) // 2)))
    place = roundabout((-FAR, 0.0), (1.0, 0.0), _swap(count, heard))
    assert math.hypot(place.x, place.y) < 1e-9
    between = 2.0 * place.radius * math.sin(math.pi / count)
    assert between == pytest.approx(WIDE * 2.0 * RADIUS)


@given(
    x=st.floats(-5.0, 5.0),
    y=st.floats(-5.0, 5.0),
    angle=st.floats(-math.pi, math.pi),
    radius=st.floats(0.01, 3.0),
    room=st.floats(1.0, 2.0),
)
def test_a_turned_way_touches_the_circle_and_has_it_to_its_right(
    x: float, y: float, angle: float, radius: float, room: float
) -> None:
    way = math.cos(angle), math.sin(angle)
    turn = Roundabout(0.0, 0.0, radius).turn((x, y), way, room)
    assert 0.0 <= turn <= STEEPEST
    if 0.0 < turn < STEEPEST and math.hypot(x, y) > room * radius:
        vx, vy = math.cos(angle + turn), math.sin(angle + turn)
        assert vx * y - vy * x == pytest.approx(room * radius, abs=1e-6)


def test_the_place_is_behind_once_it_is_passed() -> None:
    place = Roundabout(0.0, 0.0, 0.1)
    assert place.is_ahead((-0.2, 0.1), (1.0, 0.0))
    assert not place.is_ahead((0.01, 0.1), (1.0, 0.0))


def test_only_those_count_who_meet_at_about_the_same_time() -> None:
    early, some, other, late = (Encounter(0.0, 0.0, RADIUS, time) for time in (0.1, 2.0, 2.5, 6.0))
    assert together([late, other, some, early], 1.0) == [other, some]
    assert together([], 1.0) == []
