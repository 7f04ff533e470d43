"""Reciprocal velocities: half-planes, the program on them, whole runs, and waiting near the goal."""

import math
from dataclasses import replace

import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from agents.law import View
from agents.law.additions import AugmentedLaw
from agents.law.reciprocal import ReciprocalLaw, nearest, reciprocal
from agents.peers.neighbours import Neighbours
from agents.peers.state import PeerState
from deploy.library.encounters import swap
from deploy.library.load import load, resolved
from deploy.run.local import LocalFleet
from protocol.line import HalfPlane
from protocol.messages import Vector
from protocol.scenario.model import Control, RobotSpec, Scenario, Workspace

CONTACT, HORIZON = 1.0, 3.0
coordinate = st.floats(-3.0, 3.0)


def hundredths(low: int, high: int) -> st.SearchStrategy[float]:
    return st.integers(low, high).map(lambda n: 0.01 * n)


speeds = st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
angle = st.floats(-math.pi, math.pi)


def shortest_distance(rx: float, ry: float, vx: float, vy: float) -> float:
    """Between two, the other at (rx, ry) and the own relative velocity (vx, vy), within the horizon."""
    square = vx * vx + vy * vy
    time = min(max((rx * vx + ry * vy) / square, 0.0), HORIZON) if square > 0.0 else 0.0
    return math.hypot(rx - time * vx, ry - time * vy)


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(coordinate, coordinate, speeds, speeds, st.floats(0.0, 2.0), st.floats(0.0, 2.0), angle, angle)
def test_two_that_keep_to_their_half_planes_do_not_touch_within_the_horizon(
    rx: float,
    ry: float,
    one: tuple[float, float],
    other: tuple[float, float],
    along: float,
    away: float,
    first: float,
    second: float,
) -> None:
    assume(math.hypot(rx, ry) > CONTACT + 1e-3)
    mine = reciprocal((rx, ry), CONTACT, one, other, HORIZON, 0.5)
    theirs = reciprocal((-rx, -ry), CONTACT, other, one, HORIZON, 0.5)
    assert math.hypot(mine.nx, mine.ny) == pytest.approx(1.0)
    # The nearest of some velocity to each half-plane, and beyond.
    chosen = []
    for plane, size, turn in ((mine, along, first), (theirs, away, second)):
        x, y = size * math.cos(turn), size * math.sin(turn)
        excess = max(0.0, plane.nx * x + plane.ny * y - plane.limit)
        chosen.append((x - excess * plane.nx, y - excess * plane.ny))
    (vx, vy), (ux, uy) = chosen
    assert shortest_distance(rx, ry, vx - ux, vy - uy) >= CONTACT - 1e-6


def worst(x: float, y: float, limits: list[HalfPlane]) -> float:
    return max((each.nx * x + each.ny * y - each.limit for each in limits), default=-math.inf)


GRID = [(0.05 * i, 0.05 * j) for i in range(-20, 21) for j in range(-20, 21) if i * i + j * j <= 400]


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@example((0.0, 0.0), [(1.82, -0.01), (1.82, -0.01)])  # the same one twice
@given(speeds, st.lists(st.tuples(hundredths(-314, 314), hundredths(-50, 100)), max_size=6))
def test_no_velocity_is_better_than_the_programs(
    wish: tuple[float, float], data: list[tuple[float, float]]
) -> None:
    limits = [HalfPlane(math.cos(turn), math.sin(turn), limit) for turn, limit in data]
    x, y = nearest(wish, limits, 1.0)
    assert math.hypot(x, y) <= 1.0 + 1e-9
    violation = worst(x, y, limits)
    if violation <= 1e-9:
        allowed = [point for point in GRID if worst(*point, limits) <= 0.0]
        assert all(math.dist(point, wish) >= math.dist((x, y), wish) - 1e-7 for point in allowed)
    else:
        assert min(worst(*point, limits) for point in GRID) >= violation - 1e-7


def test_hard_half_planes_are_kept_where_all_are_too_many() -> None:
    wall, disk = HalfPlane(1.0, 0.0, 0.0), HalfPlane(-1.0, 0.0, -0.5)
    assert nearest((0.2, 0.0), [wall, disk], 1.0, 1)[0] == pytest.approx(0.0)
    assert nearest((0.2, 0.0), [wall, disk], 1.0, 0)[0] == pytest.approx(0.25)


def run(scenario: Scenario) -> tuple[str, int, float, float]:
    report = LocalFleet(scenario).execute()
    return report["verdict"], report["collisions"], report["nrl"], report["sim_time"]


def reciprocally(scenario: Scenario, **over: object) -> Scenario:
    control = replace(scenario.control, law="reciprocal", k=60.0)
    return replace(scenario, control=control, **over)  # type: ignore[arg-type]


@pytest.mark.slow
def test_a_swap_is_short_and_quick() -> None:
    verdict, touched, nrl, time = run(reciprocally(swap(8, 0.01, 3)))
    assert (verdict, touched) == ("arrived", 0)
    assert nrl < 1.05
    assert time < 1.25 * 8.0  # 0.8 m at 0.1 m/s


@pytest.mark.slow
@pytest.mark.parametrize("name", ["swap-6", "head-on"])
def test_exactly_symmetric_starts_are_left(name: str) -> None:
    assert run(reciprocally(load(name)))[:2] == ("arrived", 0)


RADIUS = 0.04
GOAL = (0.0, 0.0)
HERE = (0.5 * RADIUS, 0.0)
SCENARIO = Scenario(
    (RobotSpec(1, RADIUS, (-0.3, 0.0), GOAL), RobotSpec(2, RADIUS, (0.3, 0.0), (-0.1, 0.35))),
    control=Control(law="reciprocal", k=60.0),
)
LAP = RADIUS / SCENARIO.control.speed


def seen(tick: int, peer: Vector, velocity: Vector) -> View:
    """Robot 1 half a radius from its goal; the peer is on the side of the goal, and drives it away."""
    known = Neighbours({2: RADIUS})
    gamma = math.dist(peer, SCENARIO.robots[1].goal) ** 2
    known.on_state(PeerState(2, 1, tick, True, *peer, 0.0, gamma, 0.0, *velocity, radius=RADIUS), tick)
    return View(tick=tick, position=HERE, goal=GOAL, displacement=(0.0, 0.0), neighbours=known)


def test_a_robot_that_passes_is_waited_for() -> None:
    beside = (HERE[0] - 2.4 * RADIUS, 0.0)
    view = seen(0, beside, (0.0, SCENARIO.control.speed))
    assert AugmentedLaw(SCENARIO, 1).velocity(view)[0] > 0.0  # the flow would back off
    assert ReciprocalLaw(SCENARIO, 1).velocity(view) == (0.0, 0.0)


def test_a_robot_that_has_waited_in_vain_does_not_wait_again() -> None:
    law, beside = ReciprocalLaw(SCENARIO, 1), (HERE[0] - 3.5 * RADIUS, 0.0)
    long = round(40.0 * LAP / SCENARIO.time.step)
    wishes = [law.velocity(seen(tick, beside, (0.0, 0.0))) for tick in range(long)]
    begun = next(tick for tick, wish in enumerate(wishes) if wish != (0.0, 0.0))
    assert begun < 5.0 * LAP / SCENARIO.time.step
    assert (0.0, 0.0) not in wishes[begun:]


@pytest.mark.slow
def test_two_that_change_places_side_by_side_in_a_pack_do_not_wait_for_ever() -> None:
    starts = (-0.0438754, -0.0759406), (-3.05e-5, -0.0001807), (-0.0882437, -0.000101), (-0.0441882, 0.07596)
    goals = (-0.044, -0.07621), (-0.088, 0.0), (0.0, 0.0), (-0.044, 0.07621)
    robots = zip(range(1, 5), starts, goals, strict=True)
    specs = tuple(RobotSpec(number, RADIUS, start, goal) for number, start, goal in robots)
    pack = Scenario(specs, workspace=Workspace(0.148), control=Control(law="reciprocal"))
    assert LocalFleet(resolved(pack)).execute()["verdict"] == "arrived"
