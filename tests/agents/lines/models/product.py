"""The product's own modules as the models drive them: interpreted, so that a mutant may read otherwise."""

from collections.abc import Sequence
from typing import Any

from tests.interpreted import Edit, interpreted

_BODIES = "protocol.bodies.kinematics", "protocol.bodies.sweep"
_KERNEL = [f"protocol.kernel.{name}" for name in ("records", "pair", "robot", "ledger")]
_KERNEL = ["protocol.line", "protocol.crowd", *_KERNEL, "protocol.region"]
_LINES = [
    "agents.peers.neighbours",
    *(f"agents.lines.{name}" for name in ("own_set", "boundary", "negotiation", "separating_lines")),
]
ROBOT = [*_KERNEL, *_LINES, "agents.estimate", "agents.lines.safe_velocity"]
ROBOT += [f"agents.{name}" for name in ("bodies", "safety_filter", "robot")]
_WORLD = [
    *(f"world.coordinator.{name}" for name in ("roster", "keeper", "lives", "exchange", "parts")),
    *("world.plants.plant", "world.plants.integrator", "world.simulation", "world.world"),
]

# As if the models' little room were large: robots stay in regions that do not fill it.
LARGE_ROOM = (
    Edit("protocol.crowd", "_LEAST: Final = 6", "_LEAST: Final = 1"),
    Edit("protocol.crowd", "_BOUNDS: Final = 3.0", "_BOUNDS: Final = 0.5"),
)


class Product:
    """What the models take from the product.

    Args:
        edits: what reads otherwise than in the sources.
    """

    def __init__(self, edits: Sequence[Edit] = ()) -> None:
        names = [*_BODIES, *ROBOT, *_WORLD]
        modules: dict[str, Any] = dict(zip(names, interpreted(*names, edits=edits), strict=True))
        self.Robot, self.World = modules["agents.robot"].Robot, modules["world.world"].WorldCore
        self.kinematics, self.sweep = (modules[name] for name in _BODIES)
        self.lines, self.boundary = modules["agents.lines.separating_lines"], modules["agents.lines.boundary"]
        self.inertial, self.plant = modules["agents.bodies"], modules["world.plants.integrator"]
