"""Which plant a scenario asks for."""

from __future__ import annotations

from importlib.util import find_spec

from protocol.errors import UsageError
from protocol.scenario.model import Scenario
from world.plants.integrator import Integrator
from world.plants.plant import Plant


def require(plant: str) -> None:
    """Find out whether a plant's library is there, without loading it.

    Raises:
        UsageError: it is not installed; says how to.
    """
    if plant == "mujoco" and find_spec("mujoco") is None:
        raise UsageError(
            'world.plant = "mujoco" needs MuJoCo, which is not installed: pip install "disknav[mujoco]"'
        )


def plant_of(scenario: Scenario) -> Plant:
    """The plant of `scenario.world.plant`.

    Raises:
        UsageError: its library is not installed.
    """
    require(scenario.world.plant)
    if scenario.world.plant == "mujoco":
        from world.plants.physics import Physics  # only whoever asks for it needs the engine

        return Physics(scenario)
    return Integrator(scenario)
