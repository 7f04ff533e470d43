"""Ways over a grid: as the visibility graph finds them, but for what a grid cannot see."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.law.distance_field import Clearances, FieldRoute
from agents.law.obstacles import Route, WayPoints
from protocol.geometry import ConvexPolygon, Disk, Shape

RADIUS = 0.2
ROOM = ConvexPolygon(((-5.0, -4.0), (5.0, -4.0), (5.0, 4.0), (-5.0, 4.0)))


def box(x: float, y: float, wide: float, high: float) -> ConvexPolygon:
    return ConvexPolygon(((x, y), (x + wide, y), (x + wide, y + high), (x, y + high)))


def scattered(seed: int, count: int) -> list[Shape]:
    random = np.random.default_rng(seed)
    places = random.uniform((-4.0, -3.5, 0.1, 0.1), (4.0, 3.5, 0.8, 0.8), (count, 4)).tolist()
    return [
        Disk(x, y, 0.5 * wide) if n % 3 == 0 else box(x, y, wide, high)
        for n, (x, y, wide, high) in enumerate(places)
    ]


@pytest.mark.slow
@given(st.integers(0, 2**32 - 1), st.sampled_from([ROOM, Disk(0.0, 0.0, 5.5)]))
@settings(max_examples=20, deadline=None)
def test_clearance_is_the_least_distance(seed: int, room: Shape) -> None:
    shapes = scattered(seed, 12)
    field = Clearances(room, shapes, RADIUS)
    for place in np.random.default_rng(seed).uniform(-4.0, 4.0, (60, 2)).tolist():
        x, y = field.place(field.index(*place))
        clear = min(-room.distance(x, y), *(shape.distance(x, y) for shape in shapes))
        assert field.at(x, y) == pytest.approx(min(clear, field.reach))
        assert {id(shape) for shape in field.near(x, y, 0.0)} >= {
            id(shape) for shape in shapes if shape.distance(x, y) < field.reach
        }


@pytest.mark.slow
@given(st.integers(0, 2**32 - 1))
@settings(max_examples=15, deadline=None)
def test_ways_lead_to_the_goal_clear_of_everything_and_are_nearly_shortest(seed: int) -> None:
    shapes, start, goal = scattered(seed, 14), (-4.6, -3.6), (4.6, 3.6)
    exact = Route(WayPoints(ROOM, shapes, 1.3 * RADIUS)).ahead(start, goal)  # with room for the grid's steps
    route, position, length = FieldRoute(Clearances(ROOM, shapes, RADIUS), RADIUS), start, 0.0
    if exact is None or min(shape.distance(*end) for shape in shapes for end in (start, goal)) < 1.3 * RADIUS:
        return
    for _ in range(200):
        found = route.ahead(position, goal)
        for part in np.linspace(0.0, 1.0, 40).tolist():
            x, y = (p + part * (q - p) for p, q in zip(position, found[0], strict=True))
            assert min(shape.distance(x, y) for shape in shapes) > 0.8 * RADIUS
        length += math.dist(position, found[0])
        position = found[0]
        if position == goal:
            break
    assert position == goal
    assert length < 1.1 * exact[1]


def test_there_is_no_way_through_a_wall_and_one_through_its_door() -> None:
    below, above = box(-0.1, -4.0, 0.2, 3.0), box(-0.1, -0.4, 0.2, 4.4)
    for shapes, is_open in (([below, above], True), ([below, above, box(-0.05, -1.2, 0.1, 1.0)], False)):
        route = FieldRoute(Clearances(ROOM, shapes, RADIUS), RADIUS)
        assert (route.ahead((-3.0, 1.0), (3.0, 1.0)) is not None) == is_open
        assert route.ahead((1.0, 1.0), (3.0, 1.0)) == ((3.0, 1.0), 2.0)
