"""What is refused as a convex polygon, and with which words."""

from __future__ import annotations

import math

import pytest
from hypothesis import given

from protocol.geometry.defects import defect
from tests.protocol.geometry.shapes import polygons

PENTAGON = [(math.cos(math.tau * n / 5), math.sin(math.tau * n / 5)) for n in range(5)]


@given(polygons())
def test_convex_polygons_have_no_defect_in_either_sense(polygon):
    if polygon.area > 1e-5 * polygon.around.radius**2:
        assert defect(polygon.points) == defect(polygon.points[::-1]) == ""


@pytest.mark.parametrize(
    ("points", "words"),
    [
        ([(0, 0), (1, 0)], "needs three points at least"),
        ([(0, 0), (1, 0), (1, 0), (0, 1)], "points 1 and 2 are the same, or nearly"),
        ([(0, 0), (1, 0), (0, 1), (0, 0)], "points 3 and 0 are the same, or nearly"),
        ([(0, 0), (1e-170, 0), (0, 1e-170)], "points 0 and 1 are the same, or nearly"),
        ([(0, 0), (1, 1), (2, 2)], "has no area"),
        ([(0, 0), (2, 0), (2, 2), (1, 0.5)], "is not convex at point 3"),
        ([(0, 0), (1, 0.5), (2, 2), (2, 0)], "is not convex at point 1"),
        (
            [(0, 0), (1, 1), (1, 0), (0, 1)],
            "crosses itself: the side from point 0 meets the side from point 2",
        ),
        (
            [PENTAGON[2 * n % 5] for n in range(5)],
            "crosses itself: the side from point 0 meets the side from point 2",
        ),
        (
            [(0, 0), (3, 0), (1, 0), (1, 1)],
            "crosses itself: the side from point 0 meets the side from point 2",
        ),
    ],
)
def test_each_defect_is_named(points, words):
    assert defect(points) == words


def test_a_point_on_a_straight_side_is_none():
    assert defect([(0, 0), (1, 0), (2, 0), (2, 2), (0, 2)]) == ""
