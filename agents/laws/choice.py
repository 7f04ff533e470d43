"""Which law a scenario asks for."""

from __future__ import annotations

from agents.laws.gradient import GradientLaw
from agents.laws.law import Law
from protocol.scenario import Scenario


def choose(scenario: Scenario, robot: int) -> Law:
    """The law of `scenario.control.law` for one robot."""
    return GradientLaw(scenario, robot)
