"""Figures 1 and 2 of Karagoz, Bozma, Koditschek. The paper gives no numbers; these show what it shows."""

from __future__ import annotations

from collections.abc import Iterable

from protocol.scenario.file import validated
from protocol.scenario.model import Control, Point, RobotSpec, Scenario, Workspace

RADIUS = 0.04  # m
WORKSPACE = 0.30  # m
GAIN = 60.0  # the paper's k


def paper_scenario(
    name: str, description: str, seed: int, starts: Iterable[Point], goals: Iterable[Point]
) -> Scenario:
    """Equal robots 1, 2, ... in the paper's setting: radius 0.04 m in a workspace of 0.30 m, k = 60."""
    robots = tuple(
        RobotSpec(n, RADIUS, start, goal)
        for n, (start, goal) in enumerate(zip(starts, goals, strict=True), start=1)
    )
    return validated(Scenario(robots, name, description, seed, Workspace(WORKSPACE), control=Control(k=GAIN)))


def figure_1(seed: int = 0) -> Scenario:
    """Robot 1 must pass between 2 and 3, then between 4 and 5, which stand close to their goals."""
    starts = [(-0.24, 0.0), (-0.07, 0.05), (-0.07, -0.05), (0.09, 0.05), (0.09, -0.05), (0.02, 0.22)]
    goals = [(0.24, 0.0), (-0.06, 0.05), (-0.06, -0.05), (0.08, 0.05), (0.08, -0.05), (-0.04, 0.20)]
    text = "robot 1 passes between 2 and 3, then 4 and 5, which nudge aside and return"
    return paper_scenario("figure-1", text, seed, starts, goals)


def figure_2(seed: int = 0) -> Scenario:
    """Goals 5 mm apart, each robot on the far side from its own: they meet in each other's way.

    Violates Assumption 1, so the theory promises nothing. At this k the blockade is a saddle, which the
    flow leaves by circling; below k = 3 some starts stay blocked.
    """
    goals = [(0.0, 0.049), (-0.0425, -0.0245), (0.0425, -0.0245)]
    starts = [(0.01, -0.22), (0.19, 0.11), (-0.19, 0.12)]
    text = "three robots whose goals are too close together: Assumption 1 is violated"
    return paper_scenario("figure-2", text, seed, starts, goals)
