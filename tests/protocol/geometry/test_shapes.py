"""Distances, nearest points and tangents of convex sets against their definitions, point by point."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from protocol.geometry import ConvexPolygon, Shape
from tests.protocol.geometry.shapes import points, polygons, shapes

ROUNDING = 1e-12


def members(shape: Shape, count: int = 7) -> np.ndarray:
    """Points of it: combinations of its corners, or of a disk's rim and centre."""
    corners = np.array(shape.points if isinstance(shape, ConvexPolygon) else shape.outline(24))
    weights = np.random.default_rng(1).dirichlet(np.full(len(corners), 0.3), 50 * count)
    return np.vstack((corners, weights @ corners))


@given(shapes, points)
def test_the_nearest_point_is_in_the_set_and_nothing_of_it_is_nearer(shape, point):
    nearest = shape.nearest(*point)
    assert shape.distance(*nearest) <= ROUNDING
    distance = math.dist(nearest, point)
    assert abs(distance - max(0.0, shape.distance(*point))) <= ROUNDING
    assert distance <= np.hypot(*(members(shape) - point).T).min() + ROUNDING
    assert (
        math.hypot(point[0] - shape.around.x, point[1] - shape.around.y) - shape.around.radius
        <= distance + ROUNDING
    )


@given(polygons(), points)
def test_inside_the_distance_is_that_to_the_nearest_side(polygon, point):
    depths = [offset - nx * point[0] - ny * point[1] for nx, ny, offset in polygon.sides]
    assert (polygon.distance(*point) <= 0.0) == (min(depths) >= 0.0)
    if min(depths) >= 0.0:
        assert math.isclose(polygon.distance(*point), -min(depths), abs_tol=ROUNDING)


@given(shapes, st.floats(0.0, math.tau), st.floats(0.0, 0.1))
def test_a_limit_keeps_its_clearance_and_no_more(shape, angle, clearance):
    nx, ny = math.cos(angle), math.sin(angle)
    limit = shape.limit(nx, ny, clearance)
    along = members(shape) @ (nx, ny)
    assert limit + clearance <= along.min() + ROUNDING
    if isinstance(shape, ConvexPolygon):
        assert limit + clearance >= along.min() - ROUNDING
    else:
        assert math.isclose(limit + clearance, nx * shape.x + ny * shape.y - shape.radius, abs_tol=ROUNDING)


@given(polygons())
def test_corners_are_kept_counterclockwise_whatever_their_sense(polygon):
    assert polygon.area > 0.0
    assert ConvexPolygon(polygon.points[::-1]).area == polygon.area
    low, high = polygon.box
    assert all(low[0] <= x <= high[0] and low[1] <= y <= high[1] for x, y in polygon.points)
