"""The polygon: supports are exact, cuts keep exactly what they should, by brute force over its corners."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.lines.polygon import DIRECTIONS, SIDES, Polygon, around, circumscribed

angles = st.floats(0.0, 2.0 * math.pi)
cuts = st.lists(st.tuples(angles, st.floats(-0.5, 1.0)), max_size=40)
TINY = 1e-12


def unit(angle: float) -> tuple[float, float]:
    return math.cos(angle), math.sin(angle)


def cut_by(polygon: Polygon, edges: list[tuple[float, float]]) -> tuple[Polygon, list[tuple[float, float]]]:
    """What is left after these cuts, passing over those that would leave nothing; and those made."""
    made = []
    for angle, limit in edges:
        left = polygon.cut(*unit(angle), limit)
        if left is not None:
            polygon = left
            made.append((angle, limit))
    return polygon, made


@given(angles, st.floats(1e-6, 10.0))
def test_a_disk_is_taken_for_a_polygon_two_percent_larger_at_most(angle, radius) -> None:
    extent = around(radius).extent(*unit(angle))
    assert radius - TINY <= extent <= radius / math.cos(math.pi / SIDES) + TINY
    assert around(radius).radius <= 1.02 * radius


@given(cuts, angles, st.floats(0.0, 1.0))
def test_a_point_is_inside_as_long_as_no_cut_excludes_it(edges, angle, share) -> None:
    x, y = (share * part for part in unit(angle))
    polygon = around(1.0)
    for turn, limit in edges:
        nx, ny = unit(turn)
        left = polygon.cut(nx, ny, limit)
        if nx * x + ny * y <= limit - TINY:
            assert left is not None
        if left is None or nx * x + ny * y > limit:
            continue
        polygon = left
        for direction in range(48):
            nx, ny = unit(direction * math.pi / 24.0)
            assert nx * x + ny * y <= polygon.extent(nx, ny) + TINY


@given(st.lists(st.tuples(st.integers(0, SIDES - 1), st.floats(0.05, 1.0)), max_size=30), angles)
def test_the_support_is_that_of_all_points_that_satisfy_every_cut(edges, angle) -> None:
    """A linear program by brute force: the largest n.x over all crossings of two edges that are allowed."""
    limits = dict.fromkeys(range(SIDES), 1.0)
    polygon = around(1.0)
    for side, limit in edges:
        left = polygon.cut(*DIRECTIONS[side], limit)
        assert left is not None
        polygon, limits[side] = left, min(limits[side], limit)
    planes = [(*DIRECTIONS[side], limit) for side, limit in limits.items()]
    nx, ny = unit(angle)
    best = -math.inf
    for a, b, c in planes:
        for d, e, f in planes:
            if abs(a * e - b * d) > 1e-9:
                x, y = (c * e - b * f) / (a * e - b * d), (a * f - c * d) / (a * e - b * d)
                if all(p * x + q * y <= r + 1e-9 for p, q, r in planes):
                    best = max(best, nx * x + ny * y)
    assert polygon.extent(nx, ny) == pytest.approx(best, abs=1e-8)


@given(cuts)
def test_its_tightest_polygon_has_its_supports(edges) -> None:
    polygon, _ = cut_by(around(1.0), edges)
    tight = circumscribed(polygon.extents())
    assert tight.extents() == pytest.approx(polygon.extents(), abs=1e-12)
    assert len(polygon.xs) <= 2 * SIDES


def test_nothing_is_left_beyond_the_farthest_corner() -> None:
    assert around(1.0).cut(1.0, 0.0, -1.1) is None


@given(cuts, angles)
def test_the_margin_surrounds_it(edges, angle) -> None:
    bare, _ = cut_by(around(1.0), edges)
    padded = Polygon(bare.xs, bare.ys, 0.1)
    assert padded.extent(*unit(angle)) == pytest.approx(bare.extent(*unit(angle)) + 0.1)
    assert padded.radius == pytest.approx(bare.radius + 0.1)
    assert padded.widened(0.2).extents() == pytest.approx([each + 0.3 for each in bare.extents()])
    cx, cy = bare.centre()
    assert max(bare.shifted(-cx, -cy).extents()) <= max(2.0, bare.radius)
