"""The process of the recorder: its own session, one node, one file."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

from deploy.recording.bursts import BurstBus
from deploy.recording.recorder import Recorder
from protocol.connection import Connection
from protocol.drive import Stop, drive, stop_on_signal
from protocol.errors import DisknavError, UsageError
from protocol.keys import checked_run

SUCCESS, INVALID, FAULT = 0, 2, 3
_NICENESS = 5
_LAST_WORDS = 3.0  # s for the result to arrive after this process was asked to stop


def main(connection: Connection, run: str, path: Path, ready: Callable[[str], None] | None = None) -> int:
    """Record `run` to `path` until its result is there; returns the exit status.

    `ready` is told the path once nothing published from then on can be missed. 0: the recording is
    complete, or this process was asked to stop. 2: the file cannot be created. 3: no network, no world,
    or the disk is full.
    """
    try:
        with stop_on_signal():
            bus = BurstBus(connection)
            # The fleet first. On Linux this is about this thread alone: those that hear stay as quick.
            os.setpriority(os.PRIO_PROCESS, 0, _NICENESS)
            recorder = Recorder(bus, checked_run(run), path, on_ready=ready and partial(ready, str(path)))
            drive(recorder, bus, on_stop=lambda: recorder.wind_up(_LAST_WORDS))
    except Stop:
        return SUCCESS
    except DisknavError as error:
        print(f"recorder: {error}", file=sys.stderr, flush=True)
        return INVALID if isinstance(error, UsageError) else FAULT
    return SUCCESS
