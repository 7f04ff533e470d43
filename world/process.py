"""The process of the world: its own session, one node, one scenario after another."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

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
    restarts: int = 0,
    *,
    tell: Callable[[dict[str, Any]], None] = lambda _: None,
) -> int:
    """Judge `scenarios` one after another in `run`; returns the exit status.

    `gathering` is how long robots may take to join, s; `speed` and `restarts` as in `WorldNode`; `tell`
    is told every report at the end.

    0: all ran to some verdict, or this process was asked to stop (the result says interrupted).
    3: the network is gone.
    """
    node = None
    try:
        with stop_on_signal():
            bus = ZenohBus(connection)
            node = WorldNode(
                bus,
                checked_run(run),
                scenarios,
                lockstep,
                gathering=gathering,
                speed=speed,
                restarts=restarts,
                say=_say,
            )
            drive(node, bus, on_stop=partial(node.interrupt, "interrupted", "the world was asked to stop"))
    except Stop:
        _tell_all(node, tell)
        return SUCCESS
    except DisknavError as error:
        _say(error)
        return FAULT
    _tell_all(node, tell)
    return SUCCESS


def _say(what: object) -> None:
    print(f"world: {what}", file=sys.stderr, flush=True)


def _tell_all(node: WorldNode | None, tell: Callable[[dict[str, Any]], None]) -> None:
    for report in () if node is None else node.reports:
        tell(report)
