"""The wall: whatever is known of the own position, what violates nothing leaves the truth inside."""

import math
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.lines.boundary import Boundary, RoundBoundary, StraightBoundary
from agents.lines.own_set import Polygon, around
from protocol.line import ROUNDING, HalfPlane
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
    where=st.lists(st.tuples(shares, shares, shares, angles), min_size=20, max_size=20),
)
def test_what_violates_nothing_takes_no_possible_place_out(shape, place, move, noise, where) -> None:
    polygon = around(0.01)
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
        tx, ty = x + ax + c * (bx - ax), y + ay + c * (by - ay)
        if math.hypot(tx, ty) > W:
            tx, ty = W * tx / math.hypot(tx, ty), W * ty / math.hypot(tx, ty)
            if not contains(polygon, tx - x, ty - y):
                continue
        ex, ey = unit(turn)
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
    boundary, shape = RoundBoundary(W), around(0.005)
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
        assert boundary.cut((1.5 * error, 0.0), shape, (dx, dy)) is not None
        assert boundary.cut((1.5 * error, 0.0), shape, (dx, dy), 0.3) is not None
    assert boundary.cut((1.5 * error, 0.0), shape, (0.0, 0.0)) is None


WALLS = [HalfPlane(0.0, 1.0, 1.0), HalfPlane(1.0, 0.0, 1.0), HalfPlane(0.0, -1.0, 1.0)]


@pytest.mark.parametrize("boundary", [RoundBoundary(1.0), StraightBoundary(WALLS)], ids=["round", "straight"])
def test_the_outermost_part_of_a_set_is_cut_off_and_does_not_go_on(boundary: Boundary) -> None:
    diamond = Polygon([0.1, 0.0, -0.1, 0.0], [0.0, 0.1, 0.0, -0.1])
    assert boundary.beyond(0.8, 0.0, diamond) is None
    beyond, left = boundary.beyond(0.95, 0.0, diamond), boundary.cut((0.85, 0.0), diamond, (0.1, 0.0))
    for edge in (beyond, left):
        assert (edge.nx, edge.ny) == (1.0, 0.0)
