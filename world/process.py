"""The process of the world: its own session, one node."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from contextlib import closing, suppress
from functools import partial
from pathlib import Path
from typing import Any

from protocol.bus.bus import Bus, Heartbeat, drive
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from protocol.errors import BusError, CheckpointError, DisknavError, RunTakenError
from protocol.keys import checked_run, world_key, world_tokens
from protocol.process.log import LOG
from protocol.scenario.model import Scenario
from world.shell.checkpoint import Checkpoint
from world.shell.failure_detector import GATHERING
from world.shell.node import WorldNode

SUCCESS, REFUSED, FAULT, OVER = 0, 2, 3, 4
_LOOK = 0.1  # s between looks at the tokens of other worlds
_GONE = 4.0  # s after which a token is permanent: that of a dead world disappears within its lease


def main(
    connection: Connection,
    run: str,
    scenario: Scenario,
    lockstep: bool,
    gathering: float = GATHERING,
    speed: float = 0.0,
    restarts: int = 0,
    checkpoint: Path | None = None,
    *,
    on_report: Callable[[dict[str, Any]], None] = lambda _: None,
    beat: Heartbeat | None = None,
) -> int:
    """Judge `scenario` in `run`; arguments as of `WorldNode`; returns the exit status.

    With a `checkpoint` (`Checkpoint.create`) this process continues the run of one that has died, and may
    repeat its report; the file is removed at the end.

    0: there is a verdict, or this process was asked to stop (the result says interrupted).
    2: there is another world of this run.
    3: the network is lost. 4: the checkpoint is invalid, so no world can continue the run.

    Raises Stopped if a signal asks this process to end before there is a world.
    """
    kept = None
    try:
        if checkpoint is not None:
            kept = Checkpoint(checkpoint, checked_run(run), scenario, LOG.warning)
        if kept is not None and kept.progress.epochs:
            LOG.warning(f"goes on at tick {kept.progress.past.tick} of {scenario.name!r}")
        with closing(ZenohBus(connection)) as bus:
            look_for_others(bus, run)
            node = WorldNode(
                bus,
                checked_run(run),
                scenario,
                lockstep,
                gathering=gathering,
                speed=speed,
                restarts=restarts,
                warn=LOG.warning,
                info=LOG.info,
                checkpoint=kept,
                on_report=on_report,
            )
            last_words = partial(node.interrupt, "interrupted", "the world was asked to stop")
            drive(node, bus, on_stop=last_words, beat=beat)
            if node.refused:
                raise _taken(run)
        if kept is not None:
            kept.remove()
    except DisknavError as error:
        LOG.error(error)
        return {RunTakenError: REFUSED, CheckpointError: OVER}.get(type(error), FAULT)
    return SUCCESS


def look_for_others(bus: Bus, run: str) -> None:
    """Raise RunTakenError if this run has another world: one that answers, or whose token remains."""
    deadline = time.monotonic() + _GONE
    while bus.tokens(world_tokens(run)):
        with suppress(BusError):
            bus.ask(world_key(run, "scenario"), b"", _LOOK)
            raise _taken(run)
        if time.monotonic() >= deadline:
            raise _taken(run)


def _taken(run: str) -> RunTakenError:
    return RunTakenError(
        f"another world of run {run!r} is on this network: end that one first, or choose another run name"
    )


def supervised(*arguments: Any) -> int:
    """As `main`; the last argument takes the report as JSON text, also if the network fails."""
    *others, on_report = arguments
    return main(*others, on_report=lambda report: on_report(json.dumps(report)))
