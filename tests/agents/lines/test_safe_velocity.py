"""The applied velocity: all constraints to the last bit, nearest by brute force, still if need be."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.lines.boundary import RoundBoundary, StraightBoundary
from agents.lines.own_set import around
from agents.lines.safe_velocity import Limits, safe_velocity, wedge
from protocol.bodies.sweep import Sweep
from protocol.line import ROUNDING, HalfPlane

PERIOD, SPEED, ROOM = 0.05, 0.1, 0.26
REACH = PERIOD * SPEED

angles = st.floats(0.0, 2.0 * math.pi)
slacks = st.one_of(st.just(0.0), st.floats(-0.002, 2.0 * REACH), st.sampled_from([1e-18, 1e-12, 1e-9]))
velocities = st.tuples(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2))


@st.composite
def problems(draw: st.DrawFn) -> tuple[tuple[float, float], tuple[float, float], list[HalfPlane]]:
    """A desired velocity, a position in the workspace, half-planes around it."""
    angle, share = draw(angles), draw(st.one_of(st.just(1.0), st.floats(0.0, 1.0)))
    x, y = share * ROOM * math.cos(angle), share * ROOM * math.sin(angle)
    planes = []
    for turn, slack in draw(st.lists(st.tuples(angles, slacks), max_size=7)):
        nx, ny = math.cos(turn), math.sin(turn)
        planes.append(HalfPlane(nx, ny, nx * x + ny * y + slack))
    return draw(velocities), (x, y), planes


def solved(
    desired: tuple[float, float], position: tuple[float, float], planes: list[HalfPlane], noise: float = 0.0
) -> tuple[float, float]:
    limits = Limits(position, planes, [RoundBoundary(ROOM)], None)
    return safe_velocity(desired, limits, speed=SPEED, period=PERIOD, noise=noise)


@given(problems(), st.sampled_from([0.0, 0.01, 0.3, 0.9]), angles)
def test_every_constraint_holds_whatever_the_execution_noise(problem, noise, turn) -> None:
    desired, (x, y), planes = problem
    vx, vy = solved(desired, (x, y), planes, noise)
    speed = math.hypot(vx, vy)
    assert speed * PERIOD <= REACH
    for size in (0.0, noise):
        dx = (vx + size * speed * math.cos(turn)) * PERIOD
        dy = (vy + size * speed * math.sin(turn)) * PERIOD
        for plane in planes:
            slack = max(0.0, plane.slack(x, y))
            assert plane.nx * dx + plane.ny * dy <= slack + (1e-16 if size else 0.0)
        room = max(ROOM, math.hypot(x, y))
        assert math.hypot(x + dx, y + dy) <= room + (1e-16 if size else 0.0)


@pytest.mark.parametrize("far", [0.3, 9e4], ids=["here", "far off"])
@pytest.mark.parametrize("of", ["line", "wall"])
def test_a_robot_that_slides_along_an_edge_does_not_creep_over_it(far: float, of: str) -> None:
    """Each tick's addition rounds, far off by 1e-11 m, and along a straight way always alike."""
    for turn in np.linspace(0.1, 6.0, 12).tolist():
        x, y = begin = far * math.cos(0.4), far * math.sin(0.4)
        nx, ny = math.cos(turn), math.sin(turn)
        edge = HalfPlane(nx, ny, nx * x + ny * y + 3e-9)
        planes = [HalfPlane(nx, ny, edge.limit - 2.0 * ROUNDING)] if of == "line" else []
        boundary = StraightBoundary([edge] if of == "wall" else [])
        desired = SPEED * (0.3 * nx - ny), SPEED * (0.3 * ny + nx)
        for _ in range(500):
            limits = Limits((x, y), planes, [boundary], None)
            vx, vy = safe_velocity(desired, limits, speed=SPEED, period=PERIOD)
            x, y = x + vx * PERIOD, y + vy * PERIOD
            assert edge.slack(x, y) > 0.9 * ROUNDING
        assert math.dist(begin, (x, y)) > 450 * REACH


@given(problems())
def test_no_feasible_velocity_is_nearer(problem) -> None:
    desired, position, planes = problem
    v = solved(desired, position, planes)
    found = math.dist(v, desired) * PERIOD
    best = min(math.dist(p, (desired[0] * PERIOD, desired[1] * PERIOD)) for p in candidates(problem))
    assert found <= best + 2e-6  # m; where rim and lines leave only a sliver, steps of micrometres shrink


def candidates(problem) -> list[tuple[float, float]]:
    """All feasible points among which the nearest one must be: projections, and corners of two edges."""
    desired, (x, y), planes = problem
    edges = [(plane.nx, plane.ny, max(0.0, plane.slack(x, y))) for plane in planes]
    circles = [(0.0, 0.0, REACH), (-x, -y, max(ROOM, math.hypot(x, y)))]
    want = np.array(desired) * PERIOD
    points = [want, np.zeros(2)]
    for nx, ny, s in edges:
        points.append(want - (want @ (nx, ny) - s) * np.array([nx, ny]))
    for cx, cy, r in circles:
        away = want - (cx, cy)
        if np.hypot(*away) > 0.0:
            points.append(np.array([cx, cy]) + away * r / np.hypot(*away))
    for (ax, ay, a), (bx, by, b) in itertools.combinations(edges, 2):
        if abs(ax * by - ay * bx) > 1e-9:
            points.append(np.linalg.solve([[ax, ay], [bx, by]], [a, b]))
    for (nx, ny, s), (cx, cy, r) in itertools.product(edges, circles):
        offset = s - nx * cx - ny * cy
        if abs(offset) <= r:
            half = math.sqrt(r * r - offset * offset)
            foot = np.array([cx + offset * nx, cy + offset * ny])
            points += [foot + half * np.array([-ny, nx]), foot - half * np.array([-ny, nx])]
    distance = math.hypot(x, y)
    (_, _, r), (_, _, big) = circles
    if abs(big - r) <= distance <= big + r and distance > 0.0:
        along = (distance**2 + r * r - big * big) / (2.0 * distance)
        half = math.sqrt(max(0.0, r * r - along * along))
        towards = np.array([-x, -y]) / distance
        points += [along * towards + s * half * np.array([-towards[1], towards[0]]) for s in (-1, 1)]
    tight = 1e-13
    return [
        (float(px), float(py))
        for px, py in points
        if all(nx * px + ny * py <= s + tight for nx, ny, s in edges)
        and all(math.hypot(px - cx, py - cy) <= r + tight for cx, cy, r in circles)
    ]


@given(
    st.sampled_from([-1e-11, 0.0, 0.001]),
    st.floats(0.0, 0.95),
    st.sampled_from([0.0, 1e-11, 1e-3]),
    st.floats(-1.0, 1.0),
    angles,
)
def test_a_wedge_holds_whatever_the_noise(
    slack: float, noise: float, size: float, turn: float, facing: float
) -> None:
    """Also where a displacement has to lead away by what rounding may lose."""
    nx, ny = math.cos(facing), math.sin(facing)
    one, other = wedge(HalfPlane(nx, ny, slack), noise)
    apex, angle = one.limit / (one.nx * nx + one.ny * ny), facing + math.pi + turn * math.acos(noise)
    dx, dy = apex * nx + size * math.cos(angle), apex * ny + size * math.sin(angle)
    tiny = 2e-15 * (abs(dx) + abs(dy))
    assert all(side.nx * dx + side.ny * dy <= side.limit + tiny for side in (one, other))
    assert nx * dx + ny * dy + noise * math.hypot(dx, dy) <= slack + 4.0 * tiny


def test_noise_does_not_lead_across_a_line_that_is_out_of_reach_without_it() -> None:
    vx, _ = solved((0.1, 0.0), (0.0, 0.0), [HalfPlane(1.0, 0.0, 1.2 * REACH)], noise=0.5)
    assert vx * 1.5 * PERIOD == pytest.approx(1.2 * REACH)


@pytest.mark.parametrize(("slack", "towards"), [(0.001, 0.001), (-0.001, 0.0)])
def test_a_robot_of_uncertain_position_uses_the_room_there_is_and_may_move_along_a_line(
    slack: float, towards: float
) -> None:
    limits = Limits((0.0, 0.0), [HalfPlane(1.0, 0.0, slack)], [], around(0.002))
    vx, vy = safe_velocity((0.05, 0.05), limits, speed=SPEED, period=PERIOD)
    assert (vx * PERIOD, vy) == pytest.approx((towards, 0.05))


def test_a_sweep_that_leaves_the_room_on_its_way_violates_something_wherever_it_ends() -> None:
    limits, margins = Limits((0.2, 0.0), (), [RoundBoundary(ROOM)], None), [0.0, 0.01, 0.01]
    assert limits.cut(Sweep([0.0, 0.04, 0.0], [0.0] * 3, margins)) is None
    assert limits.cut(Sweep([0.0, 0.055, 0.0], [0.0] * 3, margins)) is not None
