"""Robots that change places: symmetric starts lie exactly on a saddle of the navigation function."""

from __future__ import annotations

import math

from protocol.draws import Purpose, generator
from protocol.errors import UsageError
from protocol.scenario.body import PRESETS
from protocol.scenario.file import validated
from protocol.scenario.model import Control, Point, RobotSpec, Scenario, Time, Workspace

RADIUS = 0.03  # m
CIRCLE = 0.40  # m, of the starts
SPACING = 0.10  # m, least distance between neighbours; the circle grows when there are too many
MARGIN = 0.05  # m, from the circle to the boundary
LARGEST_JITTER = 0.015  # m, keeps starts apart and inside


def swap(count: int, jitter: float = 0.0, seed: int = 0) -> Scenario:
    """Robots on a circle, each to the opposite point.

    Args:
        jitter: m; each start is moved by up to this much, which takes the fleet off the saddle.

    Raises:
        UsageError: `count` is below 2 or above 1000, or `jitter` is out of range.
    """
    if not 2 <= count <= 1000:
        raise UsageError(f"{count} robots cannot swap: choose between 2 and 1000")
    if not 0.0 <= jitter <= LARGEST_JITTER:
        raise UsageError(f"jitter {jitter:g}: choose between 0 and {LARGEST_JITTER} m")
    circle = max(CIRCLE, SPACING / (2.0 * math.sin(math.pi / count)))
    robots = _opposite(_circle(count, circle), RADIUS, jitter, seed)
    text = f"{count} robots on a circle change places" + (
        f", starts off by up to {jitter:g} m" if jitter else ""
    )
    return validated(Scenario(robots, f"swap-{count}", text, seed, Workspace(circle + MARGIN)))


def circle(count: int, jitter: float = 0.0, seed: int = 0) -> Scenario:
    """RVO2's Circle: robots of 1.5 m on a circle of 200 m change places at 2 m/s, to within a radius.

    Args:
        jitter: m; each start is moved by up to this much.

    Raises:
        UsageError: `count` is below 2 or above 250, or `jitter` is above 0.5 m.
    """
    if not 2 <= count <= 250:
        raise UsageError(f"{count} robots on RVO2's circle: choose between 2 and 250")
    if not 0.0 <= jitter <= 0.5:
        raise UsageError(f"jitter {jitter:g}: choose between 0 and 0.5 m")
    return validated(
        Scenario(
            _opposite(_circle(count, 200.0), 1.5, jitter, seed),
            f"circle-{count}",
            f"{count} robots on a circle of 200 m change places; sizes as in RVO2",
            seed,
            Workspace(220.0),
            Time(step=0.25, limit=800.0, tolerance=1.5),
            Control(speed=2.0),
        )
    )


def head_on(seed: int = 0) -> Scenario:
    """Two robots that face each other and change places, exactly on the saddle."""
    robots = (RobotSpec(1, 0.04, (-0.20, 0.0), (0.20, 0.0)), RobotSpec(2, 0.04, (0.20, 0.0), (-0.20, 0.0)))
    return validated(Scenario(robots, "head-on", "two robots change places, exactly symmetric", seed))


def turtlebots(count: int, seed: int = 0) -> Scenario:
    """TurtleBots on a circle, each to the opposite point, facing anywhere.

    Raises:
        UsageError: `count` is below 2 or above 100.
    """
    if not 2 <= count <= 100:
        raise UsageError(f"{count} robots cannot swap on wheels: choose between 2 and 100")
    body = PRESETS["turtlebot3-burger"]
    radius = body.disk or 0.0
    circle = max(4.0 * radius, (2.0 * radius + SPACING) / (2.0 * math.sin(math.pi / count)))
    draws = generator(seed, Purpose.SCENARIO).uniform(-math.pi, math.pi, size=count).tolist()
    robots = tuple(
        RobotSpec(n + 1, radius, (x, y), (0.0 - x, 0.0 - y), round(draws[n], 6))
        for n, (x, y) in enumerate(_circle(count, circle))
    )
    return validated(
        Scenario(
            robots,
            f"turtlebots-{count}",
            f"{count} robots on two wheels each change places on a circle",
            seed,
            Workspace(round(circle + radius + 2.0 * SPACING, 6)),
            Time(limit=300.0, tolerance=0.02),
            body="turtlebot3-burger",
        )
    )


def _opposite(places: list[Point], radius: float, jitter: float, seed: int) -> tuple[RobotSpec, ...]:
    """Robots that start off these places by up to `jitter`, m, and go to the opposite ones."""
    draws = generator(seed, Purpose.SCENARIO).uniform(size=(len(places), 2))
    robots = []
    for n, (x, y) in enumerate(places):
        reach, angle = jitter * math.sqrt(draws[n, 0]), math.tau * draws[n, 1]
        start = (x + reach * math.cos(angle), y + reach * math.sin(angle))
        robots.append(RobotSpec(n + 1, radius, start, (0.0 - x, 0.0 - y)))
    return tuple(robots)


def _circle(count: int, radius: float) -> list[Point]:
    """Evenly spaced points; with an even count, opposite ones are exact mirror images."""
    angles = [math.tau * n / count for n in range(count // 2 if count % 2 == 0 else count)]
    points = [(round(radius * math.cos(a), 12) + 0.0, round(radius * math.sin(a), 12) + 0.0) for a in angles]
    return points if count % 2 else points + [(0.0 - x, 0.0 - y) for x, y in points]
