"""Disks and polygons: distances, nearest points and limits; and why corners are no convex polygon."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocol.geometry import ConvexPolygon, Shape, defect, signed_area
from tests.protocol.shapes import points, polygons, shapes

ROUNDING = 1e-12


def members(shape: Shape) -> np.ndarray:
    """Points of it: combinations of its corners, or of a disk's rim and centre."""
    corners = np.array(shape.points if isinstance(shape, ConvexPolygon) else shape.outline(24))
    weights = np.random.default_rng(1).dirichlet(np.full(len(corners), 0.3), 350)
    return np.vstack((corners, weights @ corners))


@given(shapes, points)
def test_the_nearest_point_is_in_the_set_and_nothing_of_it_is_nearer(shape, point):
    nearest = shape.nearest(*point)
    assert shape.distance(*nearest) <= ROUNDING
    distance = math.dist(nearest, point)
    assert abs(distance - max(0.0, shape.distance(*point))) <= ROUNDING
    assert distance <= np.hypot(*(members(shape) - point).T).min() + ROUNDING
    assert shape.around.distance(*point) <= distance + ROUNDING


@given(polygons(), points)
def test_inside_the_distance_is_that_to_the_nearest_side(polygon, point):
    depths = [offset - nx * point[0] - ny * point[1] for nx, ny, offset in polygon.sides]
    assert (polygon.distance(*point) <= 0.0) == (min(depths) >= 0.0)
    if min(depths) >= 0.0:
        assert math.isclose(polygon.distance(*point), -min(depths), abs_tol=ROUNDING)


@given(shapes, st.floats(0.0, math.tau))
def test_a_support_is_reached_and_not_exceeded(shape, angle):
    nx, ny = math.cos(angle), math.sin(angle)
    support = shape.support(nx, ny)
    along = members(shape) @ (nx, ny)
    assert support >= along.max() - ROUNDING
    if isinstance(shape, ConvexPolygon):
        assert support <= along.max() + ROUNDING
    else:
        assert math.isclose(support, nx * shape.x + ny * shape.y + shape.radius, abs_tol=ROUNDING)


PENTAGON = [(math.cos(math.tau * n / 5), math.sin(math.tau * n / 5)) for n in range(5)]


@given(polygons())
def test_convex_polygons_have_no_defect_in_either_sense(polygon):
    if signed_area(polygon.points) > 1e-5 * polygon.around.radius**2:
        assert defect(polygon.points) == defect(polygon.points[::-1]) == ""


@pytest.mark.parametrize(
    ("points", "words"),
    [
        ([(0, 0), (1, 0)], "needs at least three points"),
        ([(0, 0), (1, 0), (1, 0), (0, 1)], "points 1 and 2 are the same, or nearly"),
        ([(0, 0), (1, 0), (0, 1), (0, 0)], "points 3 and 0 are the same, or nearly"),
        ([(0, 0), (1e-170, 0), (0, 1e-170)], "points 0 and 1 are the same, or nearly"),
        ([(0, 0), (1, 1), (2, 2)], "has no area: its points are on one line, or its sides cross"),
        ([(0, 0), (1, 1), (1, 0), (0, 1)], "has no area: its points are on one line, or its sides cross"),
        ([(0, 0), (2, 0), (2, 2), (1, 0.5)], "is not convex at point 3, or its sides cross"),
        ([(0, 0), (1, 0.5), (2, 2), (2, 0)], "is not convex at point 1, or its sides cross"),
        ([(0, 0), (3, 0), (1, 0), (1, 1)], "is not convex at point 1, or its sides cross"),
        ([PENTAGON[2 * n % 5] for n in range(5)], "goes around more than once"),
    ],
)
def test_each_defect_is_named(points, words):
    assert defect(points) == words
