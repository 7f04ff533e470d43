"""The library's swap of four, and a guest that comes to it while it runs."""

from __future__ import annotations

from dataclasses import replace

import pytest

from deploy.library.load import load
from deploy.run.local import LocalFleet
from protocol.scenario.model import Order, RobotSpec
from tests.system.orders.turnover import asked

SWAP = load("swap-4")
GUEST = RobotSpec(7, 0.03, (0.0, 0.0), (0.0, 0.22))  # where the four of them pass
GUESTED = replace(SWAP, orders=(Order(0.2, add=GUEST),))


def status(fleet: LocalFleet, robot: int) -> str:
    """What the world's roster says of a robot; "" if it does not know it."""
    return next((each.status for each in asked(fleet).roster.members if each.robot == robot), "")


def step(fleet: LocalFleet, ticks: int) -> None:
    """Go on for some ticks."""
    for _ in range(ticks):
        assert fleet.step()


def to_be(fleet: LocalFleet, robot: int, wanted: str, most: int = 400) -> None:
    """Go on until a robot has this status, for so many ticks at most."""
    for _ in range(most):
        if status(fleet, robot) == wanted:
            return
        assert fleet.step()
    pytest.fail(f"robot {robot} is {status(fleet, robot)}, not {wanted}")
