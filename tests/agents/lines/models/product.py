"""The product's own modules as the models drive them: interpreted, so that a mutant may read otherwise."""

from __future__ import annotations

from collections.abc import Sequence
from types import ModuleType
from typing import Any

from tests.interpreted import Edit, interpreted

_LINES = [
    f"agents.lines.{name}"
    for name in (
        "line",
        "own_set",
        "boundary",
        "placement",
        "ends",
        "tangent",
        "robot_pair",
        "initial_lines",
        "negotiation.entries",
        "negotiation.near",
        "negotiation.far",
        "separating_lines",
        "things",
    )
]
_ROBOT = [
    "agents.peers.roster",
    "agents.estimate",
    "agents.lines.safe_velocity",
    "agents.bodies",
    "agents.safety_filter",
    *("agents.hearing", "agents.robot"),
]
_WORLD = [
    *(f"world.coordinator.{name}" for name in ("roster", "lives", "commands", "parts", "coordinator")),
    *("world.plants.plant", "world.plants.integrator", "world.simulation", "world.world"),
]
# As if the models' little room were large: lines rest in it until somebody comes near.
LARGE_ROOM = (
    Edit("agents.lines.separating_lines", "AHEAD: Final = 20.0", "AHEAD: Final = 0.0"),
    Edit("agents.safety_filter", "urgent=urgent(scenario) if", "urgent=0.02 if"),
)


class Product:
    """What the models take from the product.

    Args:
        edits: what reads otherwise than in the sources.
    """

    def __init__(self, edits: Sequence[Edit] = ()) -> None:
        names = [*_LINES, *_ROBOT, *_WORLD]
        modules: dict[str, ModuleType] = dict(zip(names, interpreted(*names, edits=edits), strict=True))
        self.placement: Any = modules["agents.lines.negotiation.near"]  # where `fit_line` is looked up
        self.Line: Any = modules["agents.lines.line"].Line
        self.ROUNDING: float = modules["agents.lines.line"].ROUNDING
        self.SeparatingLines: Any = modules["agents.lines.separating_lines"].SeparatingLines
        self.KnownRoster: Any = modules["agents.peers.roster"].KnownRoster
        self.Robot: Any = modules["agents.robot"].Robot
        self.Roster: Any = modules["world.coordinator.roster"].Roster
        self.World: Any = modules["world.world"].World
