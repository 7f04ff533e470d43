"""The wall: whatever is known of the own position, what violates nothing leaves the truth inside."""

import math
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.lines.boundary import RoundBoundary, StraightBoundary, boundary_of
from agents.lines.own_set import Polygon, around
from protocol.geometry import ConvexPolygon, Disk, Shape
from protocol.line import ROUNDING, HalfPlane
from protocol.messages import Vector
from tests.interpreted import interpreted

W, SPEED, PERIOD = 0.26, 0.1, 0.05
REACH = SPEED * PERIOD
TINY = 1e-12  # m
angles = st.floats(0.0, 2.0 * math.pi)
shares = st.floats(0.0, 1.0)
INNER_BOUNDARY, INNER = interpreted("agents.lines.boundary", "agents.lines.safe_velocity")


def unit(angle: float) -> tuple[float, float]:
    return math.cos(angle), math.sin(angle)


@given(
    shape=st.lists(st.tuples(angles, st.floats(-0.002, 0.01)), max_size=6),
    place=st.tuples(angles, st.floats(-0.02, 0.02)),
    move=st.tuples(angles, shares),
    noise=st.sampled_from([0.0, 0.3]),
    margin=st.sampled_from([0.0, 0.001]),
    where=st.lists(st.tuples(shares, shares, shares, angles), min_size=20, max_size=20),
)
def test_what_violates_nothing_takes_no_possible_place_out(shape, place, move, noise, margin, where) -> None:
    polygon = around(0.01, margin)
    for angle, limit in shape:
        polygon = polygon.cut(*unit(angle), limit) or polygon
    angle, out = place
    x, y = ((W + out) * part for part in unit(angle))
    dx, dy = (REACH * move[1] * part for part in unit(move[0]))
    boundary = RoundBoundary(W)
    if boundary.cut((x, y), polygon, (dx, dy), noise) is not None:
        return
    corners = list(zip(polygon.xs, polygon.ys, strict=True))
    for a, b, c, turn in where:
        (ax, ay), (bx, by) = corners[int(a * (len(corners) - 1))], corners[int(b * (len(corners) - 1))]
        ex, ey = unit(turn)
        tx, ty = x + ax + c * (bx - ax) + margin * ex, y + ay + c * (by - ay) + margin * ey
        if math.hypot(tx, ty) > W:
            tx, ty = W * tx / math.hypot(tx, ty), W * ty / math.hypot(tx, ty)
            if not contains(polygon, tx - x, ty - y):
                continue
        extra = noise * math.hypot(dx, dy)
        assert math.hypot(tx + dx + extra * ex, ty + dy + extra * ey) <= W + TINY


def contains(polygon: Polygon, x: float, y: float) -> bool:
    """Whether no side of the polygon excludes a point."""
    corners = list(zip(polygon.xs, polygon.ys, strict=True))
    return all(
        (bx - ax) * (y - ay) >= (by - ay) * (x - ax)
        for (ax, ay), (bx, by) in zip(corners, corners[1:] + corners[:1], strict=True)
    )


@given(
    place=st.tuples(angles, st.floats(-0.02, 0.02)),
    move=st.tuples(angles, shares),
    noise=st.sampled_from([0.0, 0.3]),
)
def test_a_half_plane_is_violated_and_allows_to_stand_still(place, move, noise) -> None:
    x, y = ((W + place[1]) * part for part in unit(place[0]))
    dx, dy = (REACH * move[1] * part for part in unit(move[0]))
    boundary = RoundBoundary(W)
    for shape in (around(0.005), None):
        assert boundary.cut((x, y), shape, (0.0, 0.0), noise) is None
        cut = boundary.cut((x, y), shape, (dx, dy), noise)
        if cut is not None:
            assert cut.limit >= 0.0
            assert cut.nx * dx + cut.ny * dy + noise * math.hypot(dx, dy) > cut.limit - TINY


def at_the_wall(draw: random.Random) -> tuple[float, float, Polygon]:
    """A set at the wall as a robot knows it: cut by measurements, then by the workspace."""
    error = draw.choice([0.001, 0.005, 0.02])
    polygon = around(error, ROUNDING)
    for _ in range(draw.randint(0, 4)):
        cut = polygon.cut(*unit(draw.uniform(0.0, 2.0 * math.pi)), draw.uniform(-0.5, 1.0) * error)
        polygon = cut or polygon
    out = W + draw.uniform(-1.0, 0.5) * error
    x, y = (out * part for part in unit(draw.uniform(0.0, 2.0 * math.pi)))
    for _ in range(4):
        edge = RoundBoundary(W).beyond(x, y, polygon)
        cut = None if edge is None else polygon.cut(edge.nx, edge.ny, edge.slack(x, y))
        if cut is None:
            break
        cx, cy = cut.centre()
        x, y, polygon = x + cx, y + cy, cut.shifted(-cx, -cy)
    return x, y, polygon


@pytest.mark.parametrize("noise", [0.0, 0.3, 0.9])
def test_a_robot_that_can_go_where_it_wants_to_does_not_stand(noise: float) -> None:
    """Rounding at edges that leave no room at all must not cost the whole step."""
    boundary, able = INNER_BOUNDARY.RoundBoundary(W), 0
    for seed in range(400):
        draw = random.Random(seed)
        x, y, shape = at_the_wall(draw)
        wish = draw.uniform(0.0, 2.0 * math.pi)
        ways = [unit(wish + 0.1 * turn) for turn in range(-14, 15)]
        if any(
            boundary.cut((x, y), shape, (0.1 * REACH * dx, 0.1 * REACH * dy), noise) is None
            for dx, dy in ways
        ):
            able += 1
            vx, vy = INNER.safe_velocity(
                (SPEED * math.cos(wish), SPEED * math.sin(wish)),
                INNER.Limits((x, y), (), [boundary], shape),
                speed=SPEED,
                period=PERIOD,
                noise=noise,
            )
            assert math.hypot(vx, vy) > 0.0, seed
    assert able > 200


@pytest.mark.parametrize("room", [0.0, 1e-10, 1e-9, 3e-9])
@pytest.mark.parametrize("error", [1e-9, 0.02])
def test_a_robot_that_has_less_room_than_rounding_takes_stands_still(room: float, error: float) -> None:
    boundary, shape = RoundBoundary(room), around(error, ROUNDING)
    for turn in range(16):
        dx, dy = (REACH * part for part in unit(turn * math.pi / 8.0))
        for noise in (0.0, 0.3):
            cut = boundary.cut((1.5 * error, 0.0), shape, (dx, dy), noise)
            assert 0.0 <= cut.limit < cut.nx * dx + cut.ny * dy
            assert math.hypot(cut.nx, cut.ny) == pytest.approx(1.0)
    assert boundary.cut((1.5 * error, 0.0), shape, (0.0, 0.0)) is None


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("turn", [0.0, 1.5])
def test_a_step_that_takes_out_what_is_between_two_corners_violates_something(side, turn) -> None:
    """The edge from a corner outside crosses the wall where the step leads out, and either corner goes in."""

    def turned(angle: float, length: float) -> Vector:
        return tuple(length * part for part in unit(turn + side * angle))

    xs, ys = zip(*[turned(0.0, 0.27), turned(0.357, 0.2584), turned(0.0, 0.2)][:: int(side)], strict=True)
    dx, dy = turned(1.67, 0.005)
    cut = RoundBoundary(W).cut((0.0, 0.0), Polygon([*xs], [*ys]), (dx, dy))
    assert cut.limit == 0.0 < cut.nx * dx + cut.ny * dy


SQUARE = ConvexPolygon([(1.5, 1.0), (-0.9, 1.0), (-0.9, -1.4), (1.5, -1.4)])


@pytest.mark.parametrize("room", [Disk(0.3, -0.2, 1.2), SQUARE], ids=["round", "straight"])
@pytest.mark.parametrize(("ux", "uy"), [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)])
def test_the_outermost_part_of_a_set_is_cut_off_and_does_not_go_on(room: Shape, ux: float, uy: float) -> None:
    boundary = boundary_of(room, 0.2)  # whose centre stays within 1 m of (0.3, -0.2)
    arms = [(0.099, 0.0), (0.0, 0.05), (-0.099, 0.0), (0.0, -0.05)]
    rhomb = Polygon([a * ux - b * uy for a, b in arms], [a * uy + b * ux for a, b in arms], 0.001)

    def at(out: float) -> Vector:
        return 0.3 + out * ux, -0.2 + out * uy

    assert boundary.beyond(*at(0.9035), rhomb) is None
    edge = boundary.beyond(*at(0.93), rhomb)
    assert (edge.nx, edge.ny, edge.slack(*at(1.0))) == pytest.approx((ux, uy, 0.0))
    assert boundary.contains(*at(0.9 - 2.0 * ROUNDING), 0.1)
    assert not boundary.contains(*at(0.9), 0.1)
    edge = boundary.cut(at(0.85), rhomb, (0.1 * ux, 0.1 * uy))
    assert (edge.nx, edge.ny) == pytest.approx((ux, uy))
    assert edge.limit == pytest.approx(0.05 - 2.0 * ROUNDING, abs=TINY)
    for shape, out in ((rhomb, 0.85), (None, 0.95)):
        step = 0.04 * ux, 0.04 * uy
        assert boundary.cut(at(out), shape, step) is None
        assert boundary.cut(at(out), shape, step, 0.3) is not None
        assert boundary.cut(at(out), shape, step, 0.3, 0.01) is None  # by less than is tolerated
    assert (
        RoundBoundary(0.15).cut((0.099 * ux, 0.099 * uy), rhomb, (0.0, 0.0)) is None
    )  # a corner is in its centre


def test_an_exact_place_in_the_last_nanometre_before_a_wall_has_to_lead_away() -> None:
    boundary = StraightBoundary([HalfPlane(1.0, 0.0, 1.0)])
    for shape in (None, around(1e-9)):
        cut = boundary.cut((1.0 - 0.5 * ROUNDING, 3.0), shape, (0.0, 0.01), 0.0, 0.001)
        assert cut is None if shape else cut.limit == pytest.approx(-4.0 * 2.0**-51)
        assert boundary.cut((1.0 - 0.5 * ROUNDING, 3.0), shape, (-0.01, 0.01), 0.0, 0.001) is None
