"""Which law a scenario asks for. Laws to compare with need libraries that the paper's does without."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Final

from agents.law.additions import AugmentedLaw
from agents.law.api import Law, View
from agents.law.gradient import GradientLaw
from protocol.errors import LawError
from protocol.messages import Vector
from protocol.process.installation import missing_library
from protocol.scenario.model import Scenario

MOST: Final = 1e3  # radii of the workspace: the largest slice that peers are told
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
        from agents.law.comparison.orca import OrcaLaw

        return OrcaLaw(scenario, robot)
    if law == "barrier":
        from agents.law.comparison.barrier import BarrierLaw

        return BarrierLaw(scenario, robot)
    if law == "reciprocal":
        from agents.law.reciprocal import ReciprocalLaw

        return ReciprocalLaw(scenario, robot)
    if ":" in law:
        from agents.law.plugin import OwnLaw

        return OwnLaw(scenario, robot)
    return AugmentedLaw(scenario, robot) if scenario.control.additions else GradientLaw(scenario, robot)


class GuardedLaw(Law):
    """The law that a scenario asks for, and none from its first failure on: then the robot stands.

    What it tells peers of its slice is bounded. A squeezed disk, or a peer with an absurd gamma, makes
    it larger than any number that a State may hold; at the common pace no slice counts for more than the
    largest attraction, which is below the bound.

    Args:
        scenario: the run.
        robot: id of the robot to control.

    Attributes:
        failure: what failed; "" if nothing did.

    Raises:
        UsageError: there is no such law, or its library is not installed.
    """

    def __init__(self, scenario: Scenario, robot: int) -> None:
        self.failure = ""
        self._most = MOST * scenario.workspace.shape.around.radius
        self._law: Law | None = None
        try:
            self._law = choose(scenario, robot)
        except LawError as error:
            self.failure = str(error)

    def velocity(self, view: View) -> Vector:
        """See `agents.law.law.Law`."""
        if self._law is not None:
            try:
                return self._law.velocity(view)
            except LawError as error:
                self._law, self.failure = None, str(error)
        return 0.0, 0.0

    def slice_norm(self, position: Vector, goal: Vector) -> float:
        """See `agents.law.law.Law`."""
        if self._law is not None:
            try:
                return min(self._law.slice_norm(position, goal), self._most)
            except LawError as error:
                self._law, self.failure = None, str(error)
        return min(super().slice_norm(position, goal), self._most)


def require(law: str) -> None:
    """Find out whether a law's library is there, without loading it.

    Raises:
        UsageError: it is not installed; says how to.
    """
    library = _LIBRARIES.get(law)
    if library is not None and find_spec(library) is None:
        raise missing_library(f'control.law = "{law}"', library, "peers")
