"""What stands enters beta: the slice among obstacles against finite differences of log phi's ingredients."""

from __future__ import annotations

import math

from hypothesis import assume, given
from hypothesis import strategies as st

from agents.law.gradient import Slice, boundary_radius
from agents.law.obstacles import obstacle_disks
from protocol.geometry import ConvexPolygon, Disk
from tests.protocol.shapes import points, shapes

RADIUS, K, GOAL, STEP = 0.02, 9.0, (0.25, -0.1), 1e-6
SQUARE = ConvexPolygon([(-0.4, -0.4), (0.4, -0.4), (0.4, 0.4), (-0.4, 0.4)])


def log_phi_hat(room, obstacles, x, y):
    """k log gamma - log beta, as Koditschek and Rimon write it; straight walls count each."""
    beta = 0.0
    for shape in obstacles:
        extra = shape.radius if isinstance(shape, Disk) else 0.0
        beta += math.log((shape.distance(x, y) + extra) ** 2 - (RADIUS + extra) ** 2)
    if isinstance(room, Disk):
        beta += math.log((room.radius - RADIUS) ** 2 - x * x - y * y)
    else:
        beta += sum(math.log((c - nx * x - ny * y) ** 2 - RADIUS**2) for nx, ny, c in room.sides)
    return K * math.log((x - GOAL[0]) ** 2 + (y - GOAL[1]) ** 2) - beta


@given(st.sampled_from([SQUARE, Disk(0.0, 0.0, 0.45)]), st.lists(shapes, max_size=3), points)
def test_the_slice_is_the_gradient_of_gamma_k_over_beta(room, obstacles, at):
    """D_i = (gamma / k) grad log (gamma^k / beta): the earlier law of Whitcomb and Koditschek has the same
    direction everywhere, so its flow has the same paths."""
    x, y = at
    assume(all(shape.distance(x, y) > 1.2 * RADIUS for shape in obstacles))
    assume(math.dist(at, GOAL) > 0.01)
    dx, dy = Slice(GOAL, RADIUS, boundary_radius(room), K, obstacle_disks(room, obstacles, x, y))(x, y)
    gamma = math.dist(at, GOAL) ** 2
    slope = [
        (log_phi_hat(room, obstacles, x + ux, y + uy) - log_phi_hat(room, obstacles, x - ux, y - uy))
        / (2.0 * STEP)
        for ux, uy in ((STEP, 0.0), (0.0, STEP))
    ]
    expected = [gamma / K * each for each in slope]
    scale = max(math.hypot(*expected), 1e-3)
    assert math.dist((dx, dy), expected) <= 2e-4 * scale + 1e-6
