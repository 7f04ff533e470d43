"""The escape from deadlocks at any period and any length: the same robots, from centimetres to hundreds of
metres, with a world, messages and lines."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal

import pytest

from deploy.library.load import load
from deploy.run.local import LocalFleet
from protocol.scenario.model import Control, RobotSpec, Scenario, Time, Workspace

pytestmark = pytest.mark.slow


def scaled(scenario: Scenario, factor: float) -> Scenario:
    """All lengths as many times longer, in a workspace that is a disk; all robots as many times faster."""
    robots = tuple(
        replace(
            each,
            radius=factor * each.radius,
            start=(factor * each.start[0], factor * each.start[1]),
            goal=(factor * each.goal[0], factor * each.goal[1]),
        )
        for each in scenario.robots
    )
    return replace(
        scenario,
        robots=robots,
        workspace=Workspace(factor * scenario.workspace.radius),
        control=replace(scenario.control, speed=factor * scenario.control.speed),
        time=replace(scenario.time, tolerance=factor * scenario.time.tolerance),
    )


def of_library(name: str, workspace: float, period: float, pace: str) -> Scenario:
    """A scenario of the library with another workspace (m), as many times faster, and another period (s)."""
    base = load(name)
    larger = scaled(base, workspace / base.workspace.radius)
    time = replace(larger.time, step=period, limit=120.0, fence=20.0 * period, deadlock=30.0)
    return replace(larger, control=paced(larger.control, pace), time=time)


def paced(control: Control, pace: str) -> Control:
    return control if pace == "common" else control.without("pace")


def circle(count: int, radius: float, k: float, pace: Literal["common", "own"]) -> Scenario:
    """RVO2's Circle: disks of 1.5 m at 2 m/s and 4 Hz, each bound for the opposite point, `radius` in m."""
    angles = [2.0 * math.pi * n / count for n in range(count)]
    points = [(round(radius * math.cos(a), 9), round(radius * math.sin(a), 9)) for a in angles]
    return Scenario(
        tuple(RobotSpec(n, 1.5, (x, y), (-x, -y)) for n, (x, y) in enumerate(points, 1)),
        workspace=Workspace(radius + 5.0),
        control=paced(Control(k=k, speed=2.0), pace),
        time=Time(0.25, limit=600.0, tolerance=0.5),
    )


def assert_arrives(scenario: Scenario) -> None:
    report = LocalFleet(scenario).execute()
    assert (report["verdict"], report["collisions"]) == ("arrived", 0), report["reason"]


@pytest.mark.parametrize(
    ("period", "workspace", "pace"),
    [
        (0.01, 0.02, "common"),
        (0.25, 0.02, "own"),
        (0.5, 200.0, "common"),
    ],
)
def test_symmetric_robots_arrive_at_any_period_and_length(period: float, workspace: float, pace: str) -> None:
    for name in ("head-on", "swap-3"):
        assert_arrives(of_library(name, workspace, period, pace))


def test_a_few_on_a_circle_of_two_hundred_metres_arrive() -> None:
    assert_arrives(circle(5, 200.0, 60.0, "own"))


@pytest.mark.campaign
@pytest.mark.timeout(200)
def test_a_crowd_that_swings_at_full_speed_notices_that_it_gets_nowhere() -> None:
    """With a window of less than two periods this ended in a deadlock although all robots moved."""
    assert_arrives(circle(24, 19.2, 960.0, "own"))
