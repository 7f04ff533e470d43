"""Robots that bring parts to their goals: the warehouseman's problem of the paper's conclusion."""

from __future__ import annotations

import math

from deploy.library.random_instances import random_starts
from protocol.errors import UsageError
from protocol.scenario.file import validated
from protocol.scenario.model import Part, RobotSpec, Scenario, Time, Workspace

DENSITY = 0.2  # area of all disks over that of the workspace
_ROBOT, _PART = 0.03, 0.035  # m, radii: a robot grows when it takes up a part
_MOST = 40


def parts(count: int, seed: int = 0, robots: int = 3, density: float = DENSITY) -> Scenario:
    """Random parts with random goals, and robots that carry them, at this density.

    Robots end where they begin. No part's goal overlaps a robot's.

    Raises:
        UsageError: `count` is none of 1 to 40.
    """
    if not 1 <= count <= _MOST:
        raise UsageError(f"{count} parts: choose between 1 and {_MOST}")
    radii = [_ROBOT] * robots + [_PART] * count
    workspace = round(math.sqrt(sum(radius**2 for radius in radii) / density) + 5e-7, 6)
    starts = random_starts(radii, workspace, seed, 0)
    goals = _goals(radii, workspace, seed, starts[:robots])
    return validated(
        Scenario(
            tuple(RobotSpec(n + 1, _ROBOT, starts[n], starts[n]) for n in range(robots)),
            f"parts-{count}",
            f"{robots} robots bring {count} parts to their goals, density {density:.3g}",
            seed,
            Workspace(workspace),
            Time(limit=600.0, deadlock=60.0),
            parts=tuple(Part(_PART, starts[robots + n], goals[n]) for n in range(count)),
        )
    )


def _goals(
    radii: list[float], workspace: float, seed: int, homes: list[tuple[float, float]]
) -> list[tuple[float, float]]:
    """Goals of parts, apart from each other and from where robots are at home, m."""
    robots = len(homes)
    for stream in range(1, 10_000):
        drawn = random_starts(radii, workspace, seed, stream)[robots:]
        if all(math.dist(goal, home) >= 1.1 * (radii[0] + radii[robots]) for goal in drawn for home in homes):
            return drawn
    raise UsageError("no room for the goals of parts")
