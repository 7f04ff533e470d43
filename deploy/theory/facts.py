"""What both reports of `disknav check` begin with: a scenario in numbers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import msgspec
import numpy as np
from rich.table import Table

from deploy.theory.tuning import crowd, density, gain_for
from protocol.scenario.model import Scenario
from world.judge.clearance import Disks, gaps
from world.judge.measures import Goals, tight


@dataclass(frozen=True)
class Facts:
    """Numbers of a scenario; lengths in m."""

    scenario: str
    robots: int
    density: float  # area of robots and obstacles over that of the workspace
    tight: float | None
    k: float
    automatic_k: float
    start: float  # smallest clearance
    goal: float

    @classmethod
    def of(cls, scenario: Scenario) -> Self:
        """Of a valid scenario whose k is a number."""
        disks = Disks.of(scenario)
        starts, goals = (
            np.array([[complex(*getattr(scenario.spec(robot), end)) for robot in scenario.ids]])
            for end in ("start", "goal")
        )
        return cls(
            scenario.name,
            len(scenario.robots),
            density(*crowd(scenario)),
            tight(disks, Goals.of(scenario)),
            scenario.k,
            gain_for(scenario),
            float(gaps(disks, starts, starts).min()),
            float(gaps(disks, goals, goals).min()),
        )

    def table(self, among: str = ",") -> Table:
        """Table for the terminal; `among` follows the number of robots."""
        table = Table(title=self.scenario, show_header=False, title_justify="left")
        table.add_row("robots", f"{self.robots}{among} covering {self.density:.0%} of the workspace")
        table.add_row("start", f"smallest clearance {self.start:.4f} m")
        table.add_row("goals", f"smallest clearance {self.goal:.4f} m")
        table.add_row("tight", "not defined" if self.tight is None else f"{self.tight:.2f}")
        table.add_row("k in use", f"{self.k:.4g} (auto gives {self.automatic_k:.4g})")
        return table


def plain(report: Any) -> dict[str, Any]:
    """A report, which has `facts`, as plain data, with None for numbers that are not finite."""
    found = msgspec.json.decode(msgspec.json.encode(report))
    return {**found.pop("facts"), **found}
