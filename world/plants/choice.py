"""Which plant a scenario asks for."""

from __future__ import annotations

from protocol.scenario.model import Scenario
from world.plants.integrator import Integrator
from world.plants.plant import Plant


def plant_of(scenario: Scenario) -> Plant:
    """The plant of `scenario.world.plant`.

    Raises:
        UsageError: its library is not installed.
    """
    if scenario.world.plant == "mujoco":
        from world.plants.physics import Physics  # only whoever asks for it needs the engine

        return Physics(scenario)
    return Integrator(scenario)
