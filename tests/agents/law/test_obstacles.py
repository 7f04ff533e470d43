"""Obstacles in beta, the slice among them by finite differences; and the pull along paths around them."""

import math
from itertools import pairwise

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from agents.law.gradient import Slice, boundary_radius
from agents.law.obstacles import Attraction, obstacle_disks
from protocol.geometry import ConvexPolygon, Disk
from tests.protocol.shapes import points, shapes

ROOM = Disk(0.0, 0.0, 2.0)
RADIUS = 0.03
BOX = ConvexPolygon([(-0.1, -0.2), (0.1, -0.2), (0.1, 0.2), (-0.1, 0.2)])


@pytest.mark.parametrize("obstacles", [(), (Disk(0.0, 0.0, 0.1),)])
def test_alone_or_in_a_sphere_world_the_pull_is_straight(obstacles):
    assert Attraction(ROOM, RADIUS).aim((-0.5, 0.0), (0.5, 0.0), obstacles) == (0.5, 0.0)


def test_elsewhere_it_is_along_the_path_and_as_long():
    start, goal = (-0.5, 0.0), (0.5, 0.01)
    attraction = Attraction(ROOM, RADIUS, alone=True)
    x, y = attraction.aim(start, goal, (BOX,))
    corner, *others = attraction.way(start, goal, (BOX,))
    length = sum(math.dist(*ends) for ends in pairwise([start, corner, *others]))
    assert math.isclose(math.dist(start, (x, y)), length, rel_tol=0.05)
    cross = (x - start[0]) * (corner[1] - start[1]) - (y - start[1]) * (corner[0] - start[0])
    assert abs(cross) < 1e-12
    attraction.aim(start, goal, (BOX,))
    assert attraction.straight == math.dist(start, corner)
    attraction.aim((0.5, 0.5), goal, (BOX,))
    assert attraction.straight == math.inf


@pytest.mark.parametrize("gap", [1.2, 1.6, 1.99])
def test_a_path_leads_to_a_goal_that_is_nearer_to_an_obstacle_than_paths_keep(gap: float):
    start, goal = (-0.5, 0.0), (0.1 + gap * RADIUS, 0.05)
    corners = Attraction(ROOM, RADIUS).way(start, goal, (BOX,))
    assert corners[-1] == goal
    for (ax, ay), (bx, by) in pairwise([start, *corners]):
        parts = [n / 200 for n in range(201)]
        assert min(BOX.distance(ax + part * (bx - ax), ay + part * (by - ay)) for part in parts) >= RADIUS


def test_of_two_passages_one_that_two_can_pass_is_taken():
    narrow, wide = 0.05, 0.2
    obstacles = (
        ConvexPolygon([(-0.01, -2.5), (0.01, -2.5), (0.01, -narrow), (-0.01, -narrow)]),
        ConvexPolygon([(-0.01, narrow), (0.01, narrow), (0.01, 0.6), (-0.01, 0.6)]),
        ConvexPolygon([(-0.01, 0.6 + wide), (0.01, 0.6 + wide), (0.01, 2.5), (-0.01, 2.5)]),
    )
    start, goal = (-1.5, 0.0), (1.5, 0.0)
    assert Attraction(ROOM, RADIUS, alone=True).aim(start, goal, obstacles) == goal
    assert Attraction(ROOM, RADIUS).aim(start, goal, obstacles)[1] > 0.3
    assert Attraction(ROOM, RADIUS).aim(start, goal, obstacles[:2])[1] > 0.3
    near = (0.5, 0.0)
    assert Attraction(ROOM, RADIUS).aim((-0.5, 0.0), near, obstacles) == near, "the other is a long detour"


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
