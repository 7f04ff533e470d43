"""Fleets in which robots come and go: a guest among four, and what an operator asks for."""

from dataclasses import replace
from typing import Any

import msgspec
import pytest

from deploy.library.load import load
from deploy.run.local import LocalFleet
from protocol.bus.bus import Query
from protocol.keys import world_key
from protocol.operations import Reply, decode_reply
from protocol.scenario.model import Order, RobotSpec

SWAP, ENDLESS = load("swap-4"), load("swap-4", ["time.endless=true"])
GUEST = RobotSpec(7, 0.03, (0.0, 0.0), (0.0, 0.22))  # where the four of them pass
GUESTED = replace(SWAP, orders=(Order(0.2, add=GUEST),))


def asked(fleet: LocalFleet, change: dict[str, Any] | None = None) -> Reply:
    replies: list[bytes] = []
    payload = b"" if change is None else msgspec.msgpack.encode(change)
    fleet.world.handle(Query(world_key(fleet.run, "operation"), payload, replies.append))
    return decode_reply(replies[0], Reply)


def status(fleet: LocalFleet, robot: int) -> str:
    """What the world's roster says of a robot; "" if it does not know it."""
    return next((each.status for each in asked(fleet).roster.members if each.robot == robot), "")


def step(fleet: LocalFleet, ticks: int) -> None:
    for _ in range(ticks):
        assert fleet.step()


def to_be(fleet: LocalFleet, robot: int, wanted: str) -> None:
    """Go on until a robot has this status, for 400 ticks at most."""
    for _ in range(400):
        if status(fleet, robot) == wanted:
            return
        assert fleet.step()
    pytest.fail(f"robot {robot} is {status(fleet, robot)}, not {wanted}")
