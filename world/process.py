"""The process of the world: its own session, one node, one scenario after another."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from protocol.bus.connection import Connection
from protocol.bus.drive import Stop, drive, stop_on_signal, uninterrupted
from protocol.bus.heartbeat import Heartbeat
from protocol.bus.zenoh import ZenohBus
from protocol.errors import DisknavError
from protocol.keys import checked_run
from protocol.process.log import LOG
from protocol.scenario.model import Scenario
from world.shell.failure_detector import GATHERING, returning
from world.shell.node import WorldNode
from world.shell.persistence.journal import Journal
from world.shell.persistence.replay import Resumed, resume

SUCCESS, FAULT = 0, 3


def main(
    connection: Connection,
    run: str,
    scenarios: Sequence[Scenario],
    lockstep: bool,
    gathering: float = GATHERING,
    speed: float = 0.0,
    restarts: int = 0,
    journal: Path | None = None,
    *,
    tell: Callable[[dict[str, Any]], None] = lambda _: None,
    beat: Heartbeat | None = None,
) -> int:
    """Judge `scenarios` one after another in `run`; returns the exit status.

    `gathering` is how long robots may take to join, s; `speed` and `restarts` as in `WorldNode`; `tell`
    is told every report. With a `journal` (see `Journal.create`) this process goes on where another one
    died, and a report may be told again; the file is removed once all is over.

    0: all ran to some verdict, or this process was asked to stop (the result says interrupted).
    3: the network is gone, or the journal is not what it should be.
    """
    past = None
    try:
        with stop_on_signal():
            if journal is not None:
                past = resume(
                    Journal(journal, checked_run(run), scenarios, LOG.warning),
                    scenarios,
                    returning(gathering, restarts, lockstep=lockstep),
                )
                _say_where(past)
            bus = ZenohBus(connection)
            node = WorldNode(
                bus,
                checked_run(run),
                scenarios,
                lockstep,
                gathering=gathering,
                speed=speed,
                restarts=restarts,
                say=LOG.warning,
                note=LOG.info,
                past=past,
                tell=tell,
            )
            last_words = partial(node.interrupt, "interrupted", "the world was asked to stop")
            drive(node, bus, on_stop=last_words, beat=beat)
    except Stop:
        pass
    except DisknavError as error:
        LOG.error(error)
        return FAULT
    if past is not None:
        past.journal.remove()
    return SUCCESS


def supervised(*arguments: Any) -> int:
    """As `main`; the last argument takes every report as JSON text, whatever becomes of the network."""
    *others, say = arguments

    def tell(report: dict[str, Any]) -> None:
        with uninterrupted():  # half a report is none
            say(json.dumps(report))

    return main(*others, tell=tell)


def _say_where(past: Resumed) -> None:
    if past.journal.past or past.run.number:
        LOG.warning(f"goes on at tick {past.run.world.tick} of {past.run.scenario.name!r}")
