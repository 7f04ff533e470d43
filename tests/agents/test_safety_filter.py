"""What one robot may command, by its region, its workspace and what it knows of its place."""

import math

import pytest

from agents.bodies import body_of
from agents.estimate import Estimate
from agents.peers.neighbours import Neighbours
from agents.safety_filter import SafetyFilter
from deploy.library.load import load
from protocol.kernel.records import NO
from protocol.messages import BaseMotion, Grants, Sense, Vector

SCENARIO = load("swap-2", ["sensing.noise=0.001", "actuation.noise=0.1"])
RADIUS, STEP = SCENARIO.spec(1).radius, SCENARIO.time.step
ROOM = SCENARIO.workspace.disk_radius
FAST = SCENARIO.control.speed
REGION = 0.02, -0.01, RADIUS + 0.03  # m


def known(at: Vector, bound: float) -> Estimate:
    estimate = Estimate(FAST * STEP)
    estimate.update(0, Sense(at, 0, bound, (0.0, 0.0)))
    return estimate


def robot(estimate: Estimate, region: tuple[float, float, float] | None = None, **said: bool) -> SafetyFilter:
    filter_ = SafetyFilter(SCENARIO, 1, RADIUS, body_of(SCENARIO, 1))
    filter_.lines.on_grants(Grants(4, 9, 8, region, ()), Neighbours({1: RADIUS}))
    filter_.locate(0, estimate, blind=said.get("blind", False))
    return filter_


@pytest.mark.parametrize("bound", [0.0, 0.002])
@pytest.mark.parametrize("region", [None, REGION], ids=["workspace", "region"])
def test_no_execution_of_a_command_leads_out_of_the_region_or_the_workspace(region, bound) -> None:
    x, y, most = (0.0, 0.0, ROOM) if region is None else region
    for turn in range(12):
        ux, uy = math.cos(0.5 * turn), math.sin(0.5 * turn)
        reach = most - RADIUS - 1.1 * bound - 1e-4
        at = x + reach * ux, y + reach * uy
        filter_, estimate = robot(known(at, bound), region), known(at, bound)
        vx, vy = filter_.velocity((FAST * ux, FAST * uy), estimate)
        out = (vx * ux + vy * uy) * STEP * (1.0 + SCENARIO.actuation.bound)
        assert 0.0 < out <= 1e-4 + 0.1 * bound + 1e-9
        assert filter_.velocity((-FAST * ux, -FAST * uy), estimate) == pytest.approx((-FAST * ux, -FAST * uy))


def test_a_robot_stands_without_a_region_it_is_in_or_odometry_or_a_place() -> None:
    wish, sure, unknown = (FAST, 0.0), known((0.0, 0.0), 0.001), Estimate(FAST * STEP)
    assert robot(sure).velocity(wish, sure) != (0.0, 0.0)
    assert robot(sure, blind=True).velocity(wish, sure) == (0.0, 0.0)
    assert robot(unknown).velocity(wish, unknown) == (0.0, 0.0)
    assert robot(sure, (0.2, 0.0, 0.1)).velocity(wish, sure) == (0.0, 0.0)  # granted, and not adopted
    lost = known((0.0, 0.0), 0.001)
    lost.update(1, Sense((0.1, 0.0), 1, 0.001, (0.0, 0.0)))
    assert lost.lost
    assert robot(lost).velocity(wish, lost) == (0.0, 0.0)


def test_the_region_confines_the_place() -> None:
    x, y, most = REGION
    estimate = known((x, y), 0.01)
    filter_ = robot(estimate, REGION)
    inside = most - RADIUS
    estimate.update(1, Sense(None, 1, 0.0, (0.5 * inside, 0.0), 0.01))
    assert estimate.shape is not None
    before = estimate.x + estimate.shape.extent(1.0, 0.0)
    filter_.locate(1, estimate, blind=False)
    after = estimate.x + estimate.shape.extent(1.0, 0.0)
    assert x + inside <= after < min(before, x + 1.1 * inside)


@pytest.mark.parametrize(("gap", "fits"), [(0.012, True), (0.008, False)])  # m, to the wall
def test_a_disk_becomes_larger_only_where_it_is_inside_the_workspace(gap: float, fits: bool) -> None:
    estimate = known((0.0, -(ROOM - RADIUS - gap)), 0.0)
    filter_ = robot(estimate)
    assert filter_.enlarge(RADIUS + 0.01, NO, estimate) is fits
    assert filter_.radius == pytest.approx(RADIUS + (0.01 if fits else 0.0))
    assert not filter_.enlarge(RADIUS + 0.011, NO, Estimate(FAST * STEP))


@pytest.mark.parametrize("moves", [False, True])
def test_a_disk_does_not_become_larger_where_it_may_brake_into_the_wall(moves: bool) -> None:
    scenario = load("turtlebots-2")
    radius, body = scenario.spec(1).radius, body_of(scenario, 1)
    if moves:
        body.on_motion(BaseMotion((0.2, 0.0), 0.0, (0.1, 0.0)))
    filter_ = SafetyFilter(scenario, 1, radius, body)
    filter_.lines.on_grants(Grants(4, 9, 8, None, ()), Neighbours({1: radius}))
    estimate = known((scenario.workspace.shape.around.radius - radius - 0.02, 0.0), 0.0)
    filter_.locate(0, estimate, blind=False)
    assert filter_.enlarge(radius + 0.01, NO, estimate) is not moves
