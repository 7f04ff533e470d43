"""Paths over a grid: clear of everything, nearly shortest, and found exactly where a disk can pass."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from agents.law.distance_field import Clearances, FieldRoute
from agents.law.obstacles import Attraction
from agents.law.passages import gaps
from deploy.theory.surrounded import separating
from protocol.geometry import ConvexPolygon, Disk, Shape
from protocol.messages import Vector

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


def followed(route: FieldRoute, start: Vector, goal: Vector) -> list[Vector]:
    corners = [start]
    while corners[-1] != goal:
        found = route.ahead(corners[-1], goal)
        corners.append(found[0])
        assert len(corners) < 200
    return corners


@pytest.mark.slow
@given(st.integers(0, 2**32 - 1), st.sampled_from([ROOM, Disk(0.0, 0.0, 5.5)]))
@settings(max_examples=20, deadline=None)
def test_clearance_is_the_least_distance(seed: int, room: Shape) -> None:
    shapes = scattered(seed, 12)
    field = Clearances(room, shapes, RADIUS)
    for place in np.random.default_rng(seed).uniform(-4.0, 4.0, (60, 2)).tolist():
        index = field.index(*place)
        x, y = field.place(index)
        clear = min(-room.distance(x, y), *(shape.distance(x, y) for shape in shapes))
        assert field.clear[index] == pytest.approx(min(clear, field.reach))
        assert {id(shape) for shape in field.near(x, y)} >= {
            id(shape) for shape in shapes if shape.distance(x, y) < field.reach
        }


@pytest.mark.slow
@given(st.integers(0, 2**32 - 1))
@settings(max_examples=15, deadline=None)
def test_paths_lead_to_the_goal_clear_of_everything(seed: int) -> None:
    shapes, start, goal = scattered(seed, 14), (-4.6, -3.6), (4.6, 3.6)
    assume(min(shape.distance(*end) for shape in shapes for end in (start, goal)) > 1.3 * RADIUS)
    assume(separating(shapes, gaps(ROOM, shapes, 2.6 * RADIUS), start, goal) is None)
    corners = followed(FieldRoute(Clearances(ROOM, shapes, RADIUS), RADIUS), start, goal)
    for (ax, ay), (bx, by) in zip(corners[1:], corners, strict=False):
        for part in np.linspace(0.0, 1.0, 40).tolist():
            place = ax + part * (bx - ax), ay + part * (by - ay)
            assert min(shape.distance(*place) for shape in shapes) > 0.8 * RADIUS


@pytest.mark.parametrize("turn", [0.0, 0.3, 0.7])
def test_the_path_around_a_disk_is_nearly_the_shortest(turn: float) -> None:
    """That has two tangents and the arc between their points of contact."""
    away, round_ = 3.0, 1.0 + RADIUS
    goal = away * math.cos(turn), away * math.sin(turn)
    start = -goal[0], -goal[1]
    shortest = 2.0 * math.sqrt(away**2 - round_**2) + round_ * (math.pi - 2.0 * math.acos(round_ / away))
    route = FieldRoute(Clearances(ROOM, [Disk(0.0, 0.0, 1.0)], RADIUS), RADIUS)
    found = route.ahead(start, goal)
    corners = followed(route, start, goal)
    assert shortest < sum(map(math.dist, corners[1:], corners)) < 1.05 * shortest
    assert found[1] == pytest.approx(shortest, rel=0.08)


@pytest.mark.slow
@given(st.integers(0, 2**32 - 1))
@settings(max_examples=10, deadline=None)
def test_a_path_is_found_exactly_if_the_obstacles_leave_one(seed: int) -> None:
    """However narrow: by the chains of obstacles that no disk passes between, in an exact decision."""
    radius, shapes = 0.3, scattered(seed, 60)
    places = np.random.default_rng(seed).uniform((-4.7, -3.7), (4.7, 3.7), (400, 2)).tolist()
    free = [(x, y) for x, y in places if min(shape.distance(x, y) for shape in shapes) > 1.001 * radius]
    assume(len(free) > 1)
    start, goal = free[:2]
    expected = separating(shapes, gaps(ROOM, shapes, 2.0 * radius), start, goal) is None
    assert Attraction(ROOM, radius, alone=True).leads(start, goal, shapes) == expected


def test_there_is_no_path_through_a_wall_and_one_through_its_door() -> None:
    below, above = box(-0.1, -4.0, 0.2, 3.0), box(-0.1, -0.4, 0.2, 4.4)
    for shapes, is_open in (([below, above], True), ([below, above, box(-0.05, -1.2, 0.1, 1.0)], False)):
        route = FieldRoute(Clearances(ROOM, shapes, RADIUS), RADIUS)
        assert (route.ahead((-3.0, 1.0), (3.0, 1.0)) is not None) == is_open
        assert route.ahead((1.0, 1.0), (3.0, 1.0)) == ((3.0, 1.0), 2.0)


def test_no_path_crosses_a_wall_that_is_thinner_than_a_step() -> None:
    """In a very large room the grid is coarse."""
    room = ConvexPolygon(((-500.0, -500.0), (500.0, -500.0), (500.0, 500.0), (-500.0, 500.0)))
    wall = box(0.98, -500.0, 0.02, 900.0)
    clearances = Clearances(room, [wall], RADIUS)
    assert clearances.step > 5.0 * RADIUS
    corners = followed(FieldRoute(clearances, RADIUS), (-20.0, 380.0), (20.0, 380.0))
    for (ax, ay), (bx, by) in zip(corners[1:], corners, strict=False):
        assert ay + (by - ay) * (0.98 - ax) / (bx - ax) > 400.0 if (ax < 0.98) != (bx < 0.98) else True
