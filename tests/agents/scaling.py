"""A scenario at another scale, of which no law may take notice."""

from __future__ import annotations

from dataclasses import replace

from protocol.scenario.model import Scenario, Workspace


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
