"""What `disknav check` says of robots among things, or in a room with straight walls."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from agents.movers.places import Floor
from agents.movers.plan import Planner
from agents.navigation.route import Route, way_points
from deploy.theory.check.report import finite
from deploy.theory.check.scope import Theorem, theorem_for
from deploy.theory.gain.tuning import automatic_k, crowd
from protocol.scenario.model import Scenario
from world.judge.clearance import Disks, gaps
from world.judge.goals import Goals
from world.judge.measures import tight

_SAYS: dict[Theorem | None, str] = {
    "Koditschek-Rimon": (
        "A sphere world: for every k above some bound phi is a navigation function (Koditschek, Rimon 1990), "
        "so almost every start leads to the goal. The bound is not evaluated here."
    ),
    None: "Proven of arrival: nothing, for any k.",
}
_LAW = {
    True: "In a sphere world the law pulls straight, as in the theorem.",
    False: "The law follows the shortest way among the things; only tests say how often it arrives.",
}
_ORDER = {
    True: "Parts find their way to their goals one after another; only tests say how often all do.",
    False: "No order was found in which parts find their way to their goals: some must be put aside first.",
}


@dataclass(frozen=True)
class Surrounded:
    """Everything that is said. Lengths in m.

    theorem: which one speaks of this world; `reasons`, why not where there is none.
    density: area of robots and things over that of the workspace.
    start, goal: the smallest clearance there.
    unreachable: robots for which no way was found among the things, all other robots away.
    order: whether one part after another finds its way to its goal; None without parts.
    """

    scenario: str
    robots: int
    things: int
    density: float
    tight: float | None
    k: float
    automatic_k: float
    start: float
    goal: float
    theorem: Theorem | None
    reasons: tuple[str, ...]
    unreachable: tuple[int, ...]
    parts: int = 0
    order: bool | None = None

    def to_json(self) -> dict[str, Any]:
        """Plain data; an infinite number becomes None, since JSON has none."""
        return dict(finite(asdict(self)))

    def render(self) -> RenderableType:
        """Tables and sentences for the terminal."""
        table = Table(title=self.scenario, show_header=False, title_justify="left")
        carried = f" and {self.parts} parts" if self.parts else ""
        among = f"{self.robots} among {self.things} things{carried}"
        table.add_row("robots", f"{among}, together covering {self.density:.0%} of the workspace")
        table.add_row("start", f"smallest clearance {self.start:.4f} m")
        table.add_row("goals", f"smallest clearance {self.goal:.4f} m")
        table.add_row("tight", "not defined" if self.tight is None else f"{self.tight:.2f}")
        table.add_row("k in use", f"{self.k:.4g} (auto gives {self.automatic_k:.4g})")
        says = [
            *(f"Karagoz, Bozma and Koditschek's Theorem 1 does not apply: {each}." for each in self.reasons),
            _SAYS[self.theorem],
            _LAW[self.theorem is not None] if self.order is None else _ORDER[self.order],
            "That nothing touches does not depend on any of this (docs/safety.md).",
            *(f"UNREACHABLE: no way was found for robot {robot}." for robot in self.unreachable),
        ]
        return Group(table, Text(), *(Text(line) for line in says))


def surrounded(scenario: Scenario) -> Surrounded:
    """The report on a valid scenario whose k is a number."""
    theorem, reasons = theorem_for(scenario)
    radii, workspace = crowd(scenario)
    return Surrounded(
        scenario=scenario.name,
        robots=len(scenario.robots),
        things=len(scenario.things),
        density=float((radii**2).sum() / workspace**2),
        tight=tight(Disks(scenario), Goals(scenario)),
        k=scenario.k,
        automatic_k=automatic_k(radii, workspace),
        start=_clearance(scenario, "start"),
        goal=_clearance(scenario, "goal"),
        theorem=theorem,
        reasons=reasons,
        unreachable=tuple(_unreachable(scenario)),
        parts=len(scenario.parts),
        order=_has_order(scenario) if scenario.parts else None,
    )


def _clearance(scenario: Scenario, which: str) -> float:
    at = np.array([[complex(*getattr(scenario.spec(robot), which)) for robot in scenario.ids]])
    return float(gaps(Disks(scenario), at, at).min())


def _has_order(scenario: Scenario) -> bool:
    """Whether robots could bring one part after another to its goal."""
    floor = Floor(
        {number: part.start for number, part in enumerate(scenario.parts, 1)},
        tuple(thing.shape for thing in scenario.things),
    )
    starts = [each.start for each in scenario.robots]
    radii = {each.radius for each in scenario.robots}
    return any(Planner(scenario, radius).orders.exists(floor, starts) for radius in radii)


def _unreachable(scenario: Scenario) -> list[int]:
    room, shapes = scenario.workspace.shape, tuple(scenario.shapes.values())
    routes = {spec.radius: Route(way_points(room, shapes, spec.radius)) for spec in scenario.robots}
    specs = [scenario.spec(robot) for robot in scenario.ids]
    return [spec.id for spec in specs if routes[spec.radius].ahead(spec.start, spec.goal) is None]
