"""The axioms of the geometry: exact facts proved by a solver, and their rounding errors in floats.

Coordinates go up to 100 km; there a sum of two products is off by less than 0.1 nm, and what predicates may
give away is a quarter of a nanometre (`SURE`).
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import pytest
import z3
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from agents.lines.negotiation import tangent
from agents.lines.own_set import OwnSet
from agents.lines.separating_lines import Cover, CoverGeometry
from protocol.geometry import ConvexPolygon, Disk, Shape, points_of
from protocol.kernel.records import PRESENT, Held
from protocol.kernel.records import DiskRecord as Kept
from protocol.line import ROUNDING, SURE, Line
from protocol.region import Region, RegionGeometry, distance, is_beside, parting

LOST = Fraction(1, 10**10)  # m, more than floats lose at 100 km
FAR = 1e5  # m

# -- facts


def is_distance(d: Any, dx: Any, dy: Any) -> Any:
    return z3.And(d >= 0, d * d == dx * dx + dy * dy)


x, y, dx, a, b, u, v, p, q, c, d, e, f, t = z3.Reals("x y dx a b u v p q c d e f t")
ax, ay, bx, by, r, R, Q, X, Y, D, W = z3.Reals("ax ay bx by r R Q X Y D W")
_best, _near = -d * u / (u * u + v * v), (d + t * u) * (d + t * u) + t * v * t * v
FACTS = {  # assumptions and claim
    "disks of radii a and b on the two sides of a line, which is turned to x = c, are apart": (
        [a >= 0, b >= 0, ax + a <= c, bx - b >= c, is_distance(d, ax - bx, ay - by)], d >= a + b,
    ),
    "a disk in a region that is beside a line is beside it": (
        [is_distance(d, x - X, y - Y), d + r <= R, c >= X + R], x + r <= c,
    ),
    "disks in regions that are apart, around (0, 0) and (D, 0), are apart along the x-axis": (
        [d + a <= R, e + b <= Q, R + Q <= D, a >= 0, b >= 0,
         is_distance(d, ax, ay), is_distance(e, bx - D, by)],
        bx - ax >= a + b,
    ),
    "a distance is no less than its part along the x-axis": ([is_distance(d, u, v)], d >= u),
    "a disk within another one around (X, 0) that is within a region around the origin is in the region": (
        [X >= 0, X + R <= W, is_distance(d, x - X, y), d + r <= R, is_distance(f, x, y)], f + r <= W,
    ),
    "a displacement n.d <= max(0, W - n.x), n = (1, 0), that ends ahead at (x + dx, 0), ends inside": (
        [dx <= z3.If(x <= W, W - x, 0), x + dx >= 0, x * x + y * y <= W * W, W >= 0,
         is_distance(f, x + dx, 0)], f <= W,
    ),
    # Else the way from the point (d, 0) to another one of it, (d + u, v), comes nearer, at a share t of it.
    "a convex set is beyond the line through its point that is nearest to the origin": (
        [d > 0, u * u + v * v > 0, t == z3.If(_best > 1, 1, _best), z3.Implies(t >= 0, _near >= d * d)],
        u >= 0,
    ),
    "the hull of points that satisfy a half-plane satisfies it: two of them suffice, side by side": (
        [p <= c, q <= c, t >= 0, t <= 1], (1 - t) * p + t * q <= c,
    ),
}  # fmt: skip


@pytest.mark.parametrize("fact", FACTS)
def test_a_fact_follows(fact: str) -> None:
    """The assumptions are satisfiable, and imply the claim."""
    (assumed, claim), solver = FACTS[fact], z3.Solver()
    solver.set("timeout", 30_000)
    solver.add(*assumed)
    assert solver.check() == z3.sat
    solver.add(z3.Not(claim))
    assert solver.check() == z3.unsat


# -- rounding

coordinates = st.one_of(st.floats(-FAR, FAR), st.floats(-2.0, 2.0))
radii = st.floats(1e-3, 10.0)
angles = st.floats(0.0, math.tau)
slack = st.floats(-4.0 * SURE, 4.0 * SURE)  # around the threshold of predicates


@st.composite
def polygons(draw: Any) -> ConvexPolygon:
    """A regular polygon."""
    x, y, radius = draw(coordinates), draw(coordinates), draw(radii)
    sides, turn = draw(st.integers(3, 7)), draw(angles)
    corners = [turn + math.tau * each / sides for each in range(sides)]
    return ConvexPolygon([(x + radius * math.cos(a), y + radius * math.sin(a)) for a in corners])


disks = st.builds(Disk, coordinates, coordinates, radii)
shapes = st.one_of(disks, polygons())


def exact(*values: float) -> list[Fraction]:
    return [Fraction(value) for value in values]


def is_apart(shape: Shape, disk: Disk) -> bool:
    """Exactly, along the direction from the shape's nearest point to the disk."""
    (points, radius), (x, y) = points_of(shape), exact(disk.x, disk.y)
    px, py = exact(*(shape.nearest(disk.x, disk.y) if len(points) > 1 else points[0]))
    nx, ny = x - px, y - py
    gap = nx * x + ny * y - max(nx * a + ny * b for a, b in (exact(*each) for each in points))
    return gap >= 0 and gap * gap >= (Fraction(radius) + Fraction(disk.radius)) ** 2 * (nx * nx + ny * ny)


def excess(shape: Shape, line: Line, low: bool) -> Fraction:
    """Exact distance by which a shape crosses a line, m."""
    (points, radius), (nx, ny, offset) = points_of(shape), exact(line.nx, line.ny, line.offset)
    if not low:
        nx, ny, offset = -nx, -ny, -offset
    return max(nx * x + ny * y for x, y in (exact(*each) for each in points)) + Fraction(radius) - offset


def side_of(nx: float, ny: float, edge: float, low: bool) -> Line:
    return Line(nx, ny, edge) if low else Line(-nx, -ny, -edge)


def is_within(x: float, y: float, room: Fraction, region: Disk) -> bool:
    """Whether a point is within `room` of the centre of a region, exactly."""
    dx, dy = Fraction(region.x) - Fraction(x), Fraction(region.y) - Fraction(y)
    return room >= 0 and dx * dx + dy * dy <= room * room


def beside(shape: Shape, angle: float, more: float) -> Disk:
    """A disk of radius 1 m at `more` from a shape."""
    around = shape.around
    nx, ny = math.cos(angle), math.sin(angle)
    edge = shape.support(nx, ny) - (nx * around.x + ny * around.y)
    reach = edge + 1.0 + more
    return Disk(around.x + reach * nx, around.y + reach * ny, 1.0)


@settings(max_examples=100, deadline=None)
@given(shapes, angles, slack)
def test_shapes_reported_apart_are(shape: Shape, angle: float, more: float) -> None:
    disk = beside(shape, angle, more)
    if distance(shape, disk) >= SURE:
        assert is_apart(shape, disk)


@settings(max_examples=100, deadline=None)
@given(shapes, angles, slack, st.booleans())
def test_a_shape_reported_beside_a_line_is(shape: Shape, angle: float, more: float, low: bool) -> None:
    nx, ny = math.cos(angle), math.sin(angle)
    line = side_of(nx, ny, shape.support(nx, ny) + more, low)
    if is_beside(shape, line, low):
        assert excess(shape, line, low) <= Fraction(SURE) + LOST


@pytest.mark.slow
@settings(max_examples=100, deadline=None)
@given(coordinates, coordinates, radii, st.floats(0.0, 1.0), angles, slack, st.booleans())
def test_a_body_reported_to_fit_a_line_does(
    x: float, y: float, radius: float, bound: float, angle: float, more: float, low: bool
) -> None:
    nx, ny = math.cos(angle), math.sin(angle)
    line = side_of(nx, ny, nx * x + ny * y + radius + bound + more, low)
    assume(line.is_unit)
    if CoverGeometry().fits(Cover(OwnSet(x, y, bound), radius), line, low):
        assert excess(Disk(x, y, radius), line, low) + Fraction(bound) <= 0


@settings(max_examples=100, deadline=None)
@given(disks, angles, st.floats(0.0, 1.0), st.floats(-4.0 * ROUNDING, 4.0 * ROUNDING), radii)
def test_a_body_reported_inside_a_region_is(
    region: Disk, angle: float, bound: float, more: float, radius: float
) -> None:
    reach = max(0.0, region.radius - radius - bound - more)
    x, y = region.x + reach * math.cos(angle), region.y + reach * math.sin(angle)
    if CoverGeometry().inside(Cover(OwnSet(x, y, bound), radius), Region(region)):
        assert is_within(x, y, Fraction(region.radius) - Fraction(radius) - Fraction(bound), region)


@pytest.mark.slow
@settings(max_examples=100, deadline=None)
@given(st.lists(disks, min_size=1, max_size=3), st.lists(shapes, min_size=1, max_size=3))
def test_a_line_separates_all_shapes_of_two_disks(low: list[Shape], high: list[Shape]) -> None:
    line = parting(low, high)
    if line is not None:
        assert line.is_unit
        assert all(excess(each, line, True) < 0 for each in low)
        assert all(excess(each, line, False) < 0 for each in high)


@settings(max_examples=100, deadline=None)
@given(shapes, angles, st.floats(1e-6, 3.0), st.booleans(), st.sampled_from((0.0, 1e9)))
def test_a_tangent_has_the_obstacle_behind_it(
    shape: Shape, angle: float, away: float, low: bool, near: float
) -> None:
    around = shape.around
    reach = around.radius + away
    x, y = around.x + reach * math.cos(angle), around.y + reach * math.sin(angle)
    line = tangent(shape, x, y, low, near)
    if line is not None:
        assert line.is_unit
        assert excess(shape, line, not low) <= Fraction(SURE) + LOST


@settings(max_examples=100, deadline=None)
@given(disks, angles, radii, slack)
def test_a_place_reported_within_a_region_is(region: Disk, angle: float, radius: float, more: float) -> None:
    reach = max(0.0, region.radius - radius - more)
    place = Disk(region.x + reach * math.cos(angle), region.y + reach * math.sin(angle), radius)
    if RegionGeometry().within(Region(place), Held(1, Region(region))):
        assert is_within(place.x, place.y, Fraction(region.radius) - Fraction(radius) + LOST, region)


@pytest.mark.slow
@settings(max_examples=100, deadline=None)
@given(disks, angles, slack, st.lists(disks, min_size=1, max_size=3), disks)
def test_a_disk_that_is_not_around_holds_nothing_that_meets_a_region(
    region: Disk, angle: float, more: float, regions: list[Disk], place: Disk
) -> None:
    geometry, mine = RegionGeometry(), Kept(1, Held(1, Region(place)), PRESENT)
    other = Kept(2, Held(1, Region(beside(region, angle, more))), PRESENT)
    for number, each in enumerate(regions):
        other.held.grant(2 + number, Region(each))
    geometry.note(mine)
    geometry.note(other)
    if 2 not in geometry.around(mine, Region(region)):
        assert geometry.clear(other.held, Region(region))
        assert geometry.apart(other.held, mine.held)


def test_regions_of_the_whole_plane_meet_everything() -> None:
    everywhere = Held(1, Region(Disk(0.0, 0.0, math.inf)))
    place = Region(Disk(FAR, FAR, 0.1))
    assert not RegionGeometry().clear(everywhere, place)
    assert RegionGeometry().within(place, everywhere)
    assert not RegionGeometry().beside(everywhere, Line(1.0, 0.0, 0.0), True)
