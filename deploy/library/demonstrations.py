"""Scenarios to be seen rather than measured: with faults, or with what the theory asks for."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, sin

from deploy.library.goal_sets import figure_3
from protocol.scenario.model import Link, ProcessFault, RobotSpec, Scenario, Workspace


def delay_6(seed: int = 0) -> Scenario:
    """Figure 3d where states arrive up to 0.3 s late, out of order, and one in ten never."""
    return replace(
        figure_3("d", seed),
        name="delay-6",
        description="figure-3d with states delayed by 0 to 0.3 s, 10 % of them lost",
        link=Link(delay=(0.0, 0.3), loss=0.1),
    )


def crash(seed: int = 0) -> Scenario:
    """Figure 3c where the process of robot 3 is killed on the way and started again."""
    return replace(
        figure_3("c", seed),
        name="crash",
        description="figure-3c; robot 3 is killed at 1 s and started again at 3 s",
        process=(ProcessFault(3, 1.0, "kill"), ProcessFault(3, 3.0, "restart")),
    )


def admissible(seed: int = 0) -> Scenario:
    """Three robots far enough apart, in room enough, that the paper's Assumptions 1 and 2 hold.

    They start where their neighbour's goal is: nobody can go straight, yet nobody has to squeeze.
    """
    goals = [
        (0.3 * cos(angle), 0.3 * sin(angle)) for angle in (pi / 2, pi / 2 + 2 * pi / 3, pi / 2 - 2 * pi / 3)
    ]
    robots = tuple(
        RobotSpec(index + 1, 0.04, start, goal)
        for index, (start, goal) in enumerate(zip(goals[1:] + goals[:1], goals, strict=True))
    )
    return Scenario(
        robots,
        name="admissible",
        description="three robots with goals that satisfy the paper's assumptions",
        seed=seed,
        workspace=Workspace(0.9),
    )
