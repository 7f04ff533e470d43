"""The recorder on zenoh: within the router, which hears everything anyway, or as a process of its own.

A fleet's own router is the place of choice: there nothing has to be sent once more, and nobody has to
wake for it, which is most of what recording costs. It puts aside what it relays and hands it ten times
a second to the process that writes the file.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import partial
from pathlib import Path

from deploy.telemetry.recording.recorder import Recorder
from deploy.telemetry.recording.writer_process import Writer
from protocol.bus.connection import Connection
from protocol.bus.loop import drive, follow
from protocol.bus.zenoh import ZenohBus
from protocol.errors import DisknavError
from protocol.keys import checked_run, everything, world_key
from protocol.process.log import LOG

SUCCESS, FAULT = 0, 3
_NICENESS = 5
_LAST_WORDS = 3.0  # s for the result to arrive after this process was asked to stop


def main(
    connection: Connection,
    run: str,
    address: Path,
    away: float = 0.0,
    ready: Callable[[str], None] | None = None,
) -> int:
    """Hand `run` to the writer at `address` until its result is there; returns the exit status.

    `away` as in `Recorder`. `ready` is told the address once nothing published from then on can be missed.
    0: all was handed over, or this process was asked to stop. 3: no network, no world, or nobody who writes.
    """
    try:
        bus = ZenohBus(connection)
        # The fleet first. On Linux this is about this thread alone: those that hear stay as quick.
        os.setpriority(os.PRIO_PROCESS, 0, _NICENESS)
        recorder = _recorder(
            bus, checked_run(run), Writer.at(address), ready and partial(ready, str(address)), away
        )
        drive(recorder, bus, on_stop=lambda: recorder.wind_up(_LAST_WORDS))
    except DisknavError as error:
        LOG.error(error)
        return FAULT
    return SUCCESS


class Aboard:
    """A recording within a router's process: hears the run from now on, before anybody can connect."""

    def __init__(self, bus: ZenohBus, run: str, address: Path) -> None:
        self._bus, self._recorder = bus, _recorder(bus, checked_run(run), Writer.at(address))

    def follow(self) -> None:
        """Record until the result is there, or a signal asks this process to end; if that fails, say so and
        let the router go on."""
        try:
            follow(self._recorder, self._bus)
            self._recorder.wind_up(_LAST_WORDS)
        except DisknavError as error:
            LOG.error(error)


def _recorder(
    bus: ZenohBus,
    run: str,
    file: Writer,
    on_ready: Callable[[], None] | None = None,
    away: float = 0.0,
) -> Recorder:
    heard = bus.bursts(everything(run))  # one subscription, so that the order of arrival is kept
    bus.subscribe(world_key(run, "result"))
    return Recorder(bus, run, file, on_ready=on_ready, heard=heard, away=away)
