"""Runs that keep a fleet moving for as long as it takes: there and back, by the same processes."""

from __future__ import annotations

from dataclasses import replace
from math import ceil, dist

from deploy.library.load import resolved
from deploy.library.swaps import swap
from protocol.scenario.model import Scenario

_DEPARTURES = 1000  # runs of a course without a stated end


def workload(robots: int, *, speed: float = 0.1, seconds: float | None = None) -> list[Scenario]:
    """Swaps on a circle, every other one the way back, that cannot be over in `seconds` of simulated time.

    Every run ends when all have arrived, and the next begins at once, so that robots always move.
    """
    there = resolved(swap(robots))
    there = replace(
        there,
        control=replace(there.control, speed=speed),
        time=replace(there.time, limit=600.0 * 0.1 / speed, deadlock=60.0 * 0.1 / speed),
    )
    back = replace(
        there, robots=tuple(replace(robot, start=robot.goal, goal=robot.start) for robot in there.robots)
    )
    shortest = min(dist(robot.start, robot.goal) for robot in there.robots) / speed
    runs = _DEPARTURES if seconds is None else ceil(seconds / shortest) + 1
    return [(there, back)[n % 2] for n in range(runs)]
