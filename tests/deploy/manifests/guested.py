"""What orchestrators start: figure 2, and a fourth robot that orders of the scenario add a second later. Its
process is started with the others, and waits."""

from dataclasses import replace
from typing import Final

from deploy.library.load import load
from protocol.scenario.model import Order, RobotSpec, Scenario

ROBOTS: Final = (1, 2, 3, 4)
_GUEST = RobotSpec(4, 0.02, (0.2, -0.15), (0.15, -0.2))


def guested(*settings: str) -> Scenario:
    return replace(load("figure-2", settings, 4), orders=(Order(1.0, add=_GUEST),))
