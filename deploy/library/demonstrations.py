"""Scenarios with faults, to be seen rather than measured."""

from __future__ import annotations

from dataclasses import replace

from deploy.library.goal_sets import figure_3
from protocol.scenario import Link, ProcessFault, Scenario


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
