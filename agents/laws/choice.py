"""Which law a scenario asks for. Laws to compare with need libraries that the paper's does without."""

from __future__ import annotations

from importlib.util import find_spec

from agents.laws.gradient import GradientLaw
from agents.laws.law import Law
from protocol.process.installation import missing_library
from protocol.scenario.model import Scenario

_LIBRARIES = {"orca": "pyrvo", "barrier": "daqp"}


def choose(scenario: Scenario, robot: int) -> Law:
    """The law of `scenario.control.law` for one robot.

    Raises:
        UsageError: its library is not installed, or there is no such law.
        LawError: the user's law cannot be made.
    """
    law = scenario.control.law
    require(law)
    if law == "orca":
        from agents.laws.comparison.orca import OrcaLaw

        return OrcaLaw(scenario, robot)
    if law == "barrier":
        from agents.laws.comparison.barrier import BarrierLaw

        return BarrierLaw(scenario, robot)
    if law == "reciprocal":
        from agents.laws.reciprocity.reciprocal import ReciprocalLaw

        return ReciprocalLaw(scenario, robot)
    if ":" in law:
        from agents.laws.own import OwnLaw

        return OwnLaw(scenario, robot)
    return GradientLaw(scenario, robot)


def require(law: str) -> None:
    """Find out whether a law's library is there, without loading it.

    Raises:
        UsageError: it is not installed; says how to.
    """
    library = _LIBRARIES.get(law)
    if library is not None and find_spec(library) is None:
        raise missing_library(f'control.law = "{law}"', library, "peers")
