"""The gain that leads through doors: its formula against runs, and runs with the k that "auto" stands for."""

import math
from dataclasses import replace

import pytest

from deploy.library.load import resolved
from deploy.run.local import LocalFleet
from deploy.theory.tuning import PAPER_K, doors, gain_for
from protocol.scenario.file import validated
from protocol.scenario.model import Control, Obstacle, RobotSpec, Scenario, Time, Workspace

HALL, RADIUS = 40.0, 0.4


def wall(low: float, high: float) -> Obstacle:
    return Obstacle(points=((19.9, low), (20.1, low), (20.1, high), (19.9, high)))


def hall(slack: float, robots: int = 1, scale: float = 1.0, law: str = "gradient") -> Scenario:
    """A hall with a door `slack` wider than a robot; robots on its left; `scale` m for each metre."""
    half = RADIUS + 0.5 * slack
    starts = [(10.0, 10.0), (8.0, 14.0), (12.0, 25.0)][:robots]
    specs = [
        RobotSpec(n, RADIUS * scale, (x * scale, y * scale), (scale * (HALL - x), scale * (HALL - y)))
        for n, (x, y) in enumerate(starts, 1)
    ]
    obstacles = [wall(0.0, 20.0 - half), wall(20.0 + half, HALL)]
    scaled = [Obstacle(points=tuple((x * scale, y * scale) for x, y in each.points)) for each in obstacles]
    corners = ((0.0, 0.0), (HALL * scale, 0.0), (HALL * scale, HALL * scale), (0.0, HALL * scale))
    return validated(
        Scenario(
            tuple(specs),
            workspace=Workspace(points=corners),
            time=Time(0.1, 120.0, 0.05 * scale),
            control=Control(speed=scale, law=law),
            obstacles=tuple(scaled),
        )
    )


def verdict(scenario: Scenario) -> str:
    report = LocalFleet(scenario).execute()
    assert report["collisions"] == 0
    return str(report["verdict"])


@pytest.mark.slow
def test_a_robot_stops_before_a_door_below_its_gain_and_passes_above() -> None:
    slack = 0.1
    scenario = hall(slack)
    (door, *_) = doors(scenario, 1.0)
    left = math.dist((20.0, 20.0), (30.0, 30.0))
    assert door.gain == pytest.approx(left / math.sqrt((RADIUS + 0.5 * slack) ** 2 - RADIUS**2), rel=0.05)
    at = [replace(scenario, control=replace(scenario.control, k=part * door.gain)) for part in (0.9, 1.2)]
    assert [verdict(each) for each in at] == ["deadlock", "arrived"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "slack", "robots", "scale"), [("gradient", 0.001, 1, 0.1), ("reciprocal", 0.01, 3, 1.0)]
)
def test_with_k_auto_robots_pass_a_door(law: str, slack: float, robots: int, scale: float) -> None:
    assert verdict(resolved(hall(slack, robots, scale, law))) == "arrived"


def test_scale_does_not_matter_and_wide_doors_ask_for_nothing() -> None:
    assert gain_for(hall(0.02, scale=0.1)) == pytest.approx(gain_for(hall(0.02)))
    assert gain_for(hall(1.2)) == PAPER_K


def test_a_door_that_no_way_leads_through_does_not_count() -> None:
    """Nor does one that the robots pass by another, wider one."""
    scenario = hall(0.01)
    beside = replace(scenario, robots=(replace(scenario.robots[0], goal=(15.0, 25.0)),))
    assert gain_for(beside) == PAPER_K
    two = replace(scenario, obstacles=(wall(0.0, 10.0), wall(15.0, 20.0 - 0.415), wall(20.415, HALL)))
    three = replace(two, robots=(*two.robots, RobotSpec(2, RADIUS, (12.0, 12.0), (28.0, 28.0))))
    assert gain_for(two) > PAPER_K
    assert gain_for(three) < gain_for(two)
