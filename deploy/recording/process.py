"""The recorder on zenoh: within the router, which hears everything anyway, or as a process of its own.

A fleet's own router is the place of choice: there nothing has to be sent once more, and nobody has to
wake for it, which is most of what recording costs. It puts aside what it relays and hands it ten times
a second to a process beside it that writes the file.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

from deploy.recording.recorder import Recorder
from deploy.recording.writer import RecordingFile
from deploy.recording.writer_process import WriterProcess
from protocol.bus.connection import Connection
from protocol.bus.drive import Stop, drive, follow, stop_on_signal
from protocol.bus.zenoh import ZenohBus
from protocol.errors import DisknavError, UsageError
from protocol.keys import checked_run, everything, world_key

SUCCESS, INVALID, FAULT = 0, 2, 3
_NICENESS = 5
_LAST_WORDS = 3.0  # s for the result to arrive after this process was asked to stop


def main(
    connection: Connection,
    run: str,
    path: Path,
    away: float = 0.0,
    ready: Callable[[str], None] | None = None,
) -> int:
    """Record `run` to `path` until its result is there; returns the exit status.

    `away` as in `Recorder`. `ready` is told the path once nothing published from then on can be missed.
    0: the recording is complete, or this process was asked to stop. 2: the file cannot be created.
    3: no network, no world, or the disk is full.
    """
    try:
        with stop_on_signal():
            bus = ZenohBus(connection)
            # The fleet first. On Linux this is about this thread alone: those that hear stay as quick.
            os.setpriority(os.PRIO_PROCESS, 0, _NICENESS)
            recorder = _recorder(
                bus, checked_run(run), RecordingFile(path), ready and partial(ready, str(path)), away
            )
            drive(recorder, bus, on_stop=lambda: recorder.wind_up(_LAST_WORDS))
    except Stop:
        return SUCCESS
    except DisknavError as error:
        _tell(error)
        return INVALID if isinstance(error, UsageError) else FAULT
    return SUCCESS


class Aboard:
    """A recording within a router's process. To be made before its session: it forks.

    Raises:
        UsageError: the file cannot be created.
    """

    def __init__(self, run: str, path: Path) -> None:
        self._run, self._file = checked_run(run), WriterProcess(path, run)

    def begin(self, bus: ZenohBus) -> None:
        """Hear the run from now on, before anybody can connect."""
        self._bus, self._recorder = bus, _recorder(bus, self._run, self._file)

    def follow(self) -> None:
        """Record until the result is there, or `Stop`; if that fails, say so and let the router go on."""
        try:
            try:
                follow(self._recorder, self._bus)
            except Stop:
                self._recorder.wind_up(_LAST_WORDS)
                raise
        except DisknavError as error:
            _tell(error)


def _recorder(
    bus: ZenohBus,
    run: str,
    file: RecordingFile | WriterProcess,
    on_ready: Callable[[], None] | None = None,
    away: float = 0.0,
) -> Recorder:
    heard = bus.bursts(everything(run))  # one subscription, so that the order of arrival is kept
    bus.subscribe(world_key(run, "result"))
    return Recorder(bus, run, file, on_ready=on_ready, heard=heard, away=away)


def _tell(error: DisknavError) -> None:
    print(f"recorder: {error}", file=sys.stderr, flush=True)
