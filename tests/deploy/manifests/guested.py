"""What orchestrators start: a pair, and a third robot that an order of the scenario adds a second later. Its
process is started with the others, and waits."""

from dataclasses import replace
from typing import Final

from deploy.library.load import load
from protocol.scenario.model import Order, RobotSpec, Scenario

ROBOTS: Final = (1, 2, 3)
_GUEST = RobotSpec(3, 0.02, (0.2, -0.15), (0.15, -0.2))


def guested(*settings: str) -> Scenario:
    return replace(load("swap-2", settings), orders=(Order(1.0, add=_GUEST),))
