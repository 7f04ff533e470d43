"""Obstacles in beta, the slice among them by finite differences; shortest ways, and the pull along them."""

import math
from itertools import pairwise

import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from agents.law.gradient import Slice, boundary_radius
from agents.law.obstacles import MARGIN, Attraction, Route, obstacle_disks, way_points
from protocol.geometry import ConvexPolygon, Disk, Shape
from tests.protocol.shapes import points, shapes

ROOM = Disk(0.0, 0.0, 2.0)
RADIUS = 0.03
BOX = ConvexPolygon([(-0.1, -0.2), (0.1, -0.2), (0.1, 0.2), (-0.1, 0.2)])


def way(route: Route, start: tuple[float, float], goal: tuple[float, float]) -> list[tuple[float, float]]:
    corners = [start]
    while corners[-1] != goal:
        found = route.ahead(corners[-1], goal)
        corners.append(found[0])
        assert len(corners) < 100
    return corners


def clearance(shape: Shape, one: tuple[float, float], other: tuple[float, float]) -> float:
    """Smallest distance from a shape along a straight way, densely sampled."""
    parts = [n / 200 for n in range(201)]
    return min(
        shape.distance(one[0] + t * (other[0] - one[0]), one[1] + t * (other[1] - one[1])) for t in parts
    )


SLIVER = ConvexPolygon(
    [
        (0.002210537552115716, 0.0311717183313767),
        (0.0018305281463367985, 0.030722716659778253),
        (0.0013948990691233741, 0.029340220788917206),
        (0.0009168866895476232, 0.027066237156253),
        (-0.0018305281463367996, -0.030722716659778257),
    ]
)


@pytest.mark.slow
@settings(deadline=None, max_examples=25)
@given(st.lists(shapes, min_size=1, max_size=4), points, points)
@example([SLIVER], (0.0, 0.0625), (0.0, -0.25))  # from its corner a shorter one is seen
def test_ways_are_clear_and_no_longer_than_they_say(obstacles, start, goal):
    """From where the disk itself is clear; from a corner a chord of the ring around an obstacle may be seen
    that is clear of the obstacle, too, so that the rest of the way is a little shorter, never longer."""
    free = [s for s in obstacles if min(s.distance(*start), s.distance(*goal)) > RADIUS * (1.0 + MARGIN)]
    route = Route(way_points(ROOM, tuple(free), RADIUS))
    found = route.ahead(start, goal)
    if found is None:
        return
    corners = way(route, start, goal)
    length = sum(math.dist(*ends) for ends in pairwise(corners))
    assert (1.0 - MARGIN) * found[1] <= length <= found[1] * (1.0 + 1e-9)
    assert length >= math.dist(start, goal) - 1e-12
    for ends in pairwise(corners):
        assert all(clearance(shape, *ends) >= RADIUS * (1.0 - 0.03) for shape in free)


def test_through_a_gap_that_is_too_narrow_there_is_no_way():
    half = ConvexPolygon([(-0.01, 0.05), (0.01, 0.05), (0.01, 2.5), (-0.01, 2.5)])
    other = ConvexPolygon([(-0.01, -0.005), (0.01, -0.005), (0.01, -2.5), (-0.01, -2.5)])
    assert Route(way_points(ROOM, (half, other), RADIUS)).ahead((-0.5, 0.0), (0.5, 0.0)) is None
    assert Route(way_points(ROOM, (half, other), 0.5 * RADIUS)).ahead((-0.5, 0.0), (0.5, 0.0)) is not None


@pytest.mark.parametrize("obstacles", [(), (Disk(0.0, 0.0, 0.1),)])
def test_alone_or_in_a_sphere_world_the_pull_is_straight(obstacles):
    assert Attraction(ROOM, RADIUS).aim((-0.5, 0.0), (0.5, 0.0), obstacles) == (0.5, 0.0)


def test_elsewhere_it_is_along_the_way_and_as_long():
    start, goal = (-0.5, 0.0), (0.5, 0.01)
    attraction = Attraction(ROOM, RADIUS, alone=True)
    x, y = attraction.aim(start, goal, (BOX,))
    (corner, length) = Route(way_points(ROOM, (BOX,), RADIUS)).ahead(start, goal)
    assert math.isclose(math.dist(start, (x, y)), length)
    cross = (x - start[0]) * (corner[1] - start[1]) - (y - start[1]) * (corner[0] - start[0])
    assert abs(cross) < 1e-12
    assert attraction.straight == math.dist(start, corner)
    attraction.aim((0.5, 0.5), goal, (BOX,))
    assert attraction.straight == math.inf


@pytest.mark.parametrize("gap", [1.2, 1.6, 1.99])
def test_a_way_leads_to_a_goal_that_is_nearer_to_a_obstacle_than_ways_keep(gap: float):
    start, goal = (-0.5, 0.0), (0.1 + gap * RADIUS, 0.05)
    corners = way(Route(way_points(ROOM, (BOX,), 2.0 * RADIUS)), start, goal)
    assert corners[-1] == goal
    assert all(clearance(BOX, *leg) >= RADIUS for leg in pairwise(corners))


def test_of_two_passages_one_that_two_can_pass_is_taken():
    narrow, wide = 0.05, 0.2
    obstacles = (
        ConvexPolygon([(-0.01, -2.5), (0.01, -2.5), (0.01, -narrow), (-0.01, -narrow)]),
        ConvexPolygon([(-0.01, narrow), (0.01, narrow), (0.01, 0.6), (-0.01, 0.6)]),
        ConvexPolygon([(-0.01, 0.6 + wide), (0.01, 0.6 + wide), (0.01, 2.5), (-0.01, 2.5)]),
    )
    goal = (0.5, 0.0)
    assert Attraction(ROOM, RADIUS, alone=True).aim((-0.5, 0.0), goal, obstacles) == goal
    assert Attraction(ROOM, RADIUS).aim((-0.5, 0.0), goal, obstacles)[1] > 0.3
    assert Attraction(ROOM, RADIUS).aim((-0.5, 0.0), goal, obstacles[:2])[1] > 0.3


DISK, K, GOAL, STEP = 0.02, 9.0, (0.25, -0.1), 1e-6
SQUARE = ConvexPolygon([(-0.4, -0.4), (0.4, -0.4), (0.4, 0.4), (-0.4, 0.4)])


def log_phi_hat(room, obstacles, x, y):
    """k log gamma - log beta, as Koditschek and Rimon write it; straight walls count each."""
    beta = 0.0
    for shape in obstacles:
        extra = shape.radius if isinstance(shape, Disk) else 0.0
        beta += math.log((shape.distance(x, y) + extra) ** 2 - (DISK + extra) ** 2)
    if isinstance(room, Disk):
        beta += math.log((room.radius - DISK) ** 2 - x * x - y * y)
    else:
        beta += sum(math.log((c - nx * x - ny * y) ** 2 - DISK**2) for nx, ny, c in room.sides)
    return K * math.log((x - GOAL[0]) ** 2 + (y - GOAL[1]) ** 2) - beta


@given(st.sampled_from([SQUARE, Disk(0.0, 0.0, 0.45)]), st.lists(shapes, max_size=3), points)
def test_the_slice_is_the_gradient_of_gamma_k_over_beta(room, obstacles, at):
    """D_i = (gamma / k) grad log (gamma^k / beta): the earlier law of Whitcomb and Koditschek has the same
    direction everywhere, so its flow has the same paths."""
    x, y = at
    assume(all(shape.distance(x, y) > 1.2 * DISK for shape in obstacles))
    assume(math.dist(at, GOAL) > 0.01)
    dx, dy = Slice(GOAL, DISK, boundary_radius(room), K, obstacle_disks(room, obstacles, x, y))(x, y)
    gamma = math.dist(at, GOAL) ** 2
    slope = [
        (log_phi_hat(room, obstacles, x + ux, y + uy) - log_phi_hat(room, obstacles, x - ux, y - uy))
        / (2.0 * STEP)
        for ux, uy in ((STEP, 0.0), (0.0, STEP))
    ]
    expected = [gamma / K * each for each in slope]
    scale = max(math.hypot(*expected), 1e-3)
    assert math.dist((dx, dy), expected) <= 2e-4 * scale + 1e-6
