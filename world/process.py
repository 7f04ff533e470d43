"""The process of the world: its own session, one node, one scenario after another."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from protocol.bus_zenoh import ZenohBus
from protocol.connection import Connection
from protocol.drive import Stop, drive, stop_on_signal
from protocol.errors import DisknavError
from protocol.keys import checked_run
from protocol.scenario import Scenario
from world.node import GATHERING, WorldNode

SUCCESS, FAULT = 0, 3


def main(
    connection: Connection,
    run: str,
    scenarios: Sequence[Scenario],
    lockstep: bool,
    gathering: float = GATHERING,
    speed: float = 0.0,
) -> int:
    """Judge `scenarios` one after another in `run`; returns the exit status.

    `gathering` is how long robots may take to join, s; `speed` as in `WorldNode`.

    0: all ran to some verdict, or this process was asked to stop (the result says interrupted).
    3: the network is gone.
    """
    try:
        with stop_on_signal():
            bus = ZenohBus(connection)
            node = WorldNode(bus, checked_run(run), scenarios, lockstep, gathering=gathering, speed=speed)
            drive(node, bus, on_stop=lambda: node.interrupt("interrupted", "the world was asked to stop"))
    except Stop:
        return SUCCESS
    except DisknavError as error:
        print(f"world: {error}", file=sys.stderr, flush=True)
        return FAULT
    return SUCCESS
