"""A recording that is written by a process beside this one, which has better things to do."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Sequence
from multiprocessing.connection import Connection as Pipe
from pathlib import Path
from typing import Any

import msgspec

from deploy.recording.writer import RecordingFile
from protocol.bus.drive import uninterrupted
from protocol.errors import DisknavError, RecordingError, UsageError
from protocol.scenario.model import Scenario
from protocol.title import entitle

_PATIENCE = 30.0  # s that the other process may take to open or to finish the file
_NICENESS = 10  # the fleet first, and yet a share of a busy machine
_pack = msgspec.msgpack.encode  # cheaper than pickling each pair
_UNPACK = msgspec.msgpack.Decoder(list[tuple[str, bytes]])
_FORK = multiprocessing.get_context("fork")  # at once, and with everything imported already


class WriterProcess:
    """What `RecordingFile` does, done elsewhere: this process only hands messages over.

    If this process dies, all that it handed over is still written.

    Raises:
        UsageError: the file cannot be created.
        RecordingError: (all methods) it cannot be written any more.
    """

    def __init__(self, path: Path, run: str = "") -> None:
        self.path = path
        self._pipe, other = _FORK.Pipe()
        self._process = _FORK.Process(target=_write, args=(self._pipe, other, path, run), daemon=True)
        self._process.start()
        other.close()
        refused = self._answer()
        if refused:
            raise UsageError(refused)

    def begin(self, run: str, scenario: Scenario) -> None:
        """See `RecordingFile.begin`."""
        self._ask("begin", run, scenario)

    def write(self, batch: Sequence[tuple[str, bytes]]) -> None:
        """See `RecordingFile.write`."""
        self._ask("write", _pack(batch))

    def flush(self) -> None:
        """See `RecordingFile.flush`."""
        self._ask("flush")

    def finish(self, result: str | None) -> None:
        """See `RecordingFile.finish`."""
        with uninterrupted():
            self._ask("finish", result)
            failed = self._answer()
            self._process.join(_PATIENCE)
        if failed:
            raise RecordingError(failed)

    def _ask(self, method: str, *arguments: Any) -> None:
        try:
            with uninterrupted():
                self._pipe.send((method, arguments))
        except OSError as error:
            raise RecordingError(self._answer() or self._silence) from error

    def _answer(self) -> str:
        """What went wrong over there; empty if nothing did."""
        try:
            if self._pipe.poll(_PATIENCE):
                return str(self._pipe.recv())
        except (EOFError, OSError):
            pass  # told below: who writes is gone without a word
        return self._silence

    @property
    def _silence(self) -> str:
        return (
            f"cannot go on recording to {self.path}: the process that writes it is gone, or does not answer"
        )


def _write(inherited: Pipe, pipe: Pipe, path: Path, run: str) -> None:
    """Do as told until the file is finished, or whoever tells is gone."""
    entitle("writer", run)
    inherited.close()
    os.nice(_NICENESS)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)  # the other process ends this one, by finishing
    try:
        file = RecordingFile(path)
        pipe.send("")
        method = ""
        while method != "finish":
            method, arguments = pipe.recv()
            if method == "write":
                arguments = map(_UNPACK.decode, arguments)
            getattr(file, method)(*arguments)
        pipe.send("")
    except EOFError:
        file.flush()  # what has been said is kept, and the file is a cut one
    except DisknavError as error:
        pipe.send(str(error))
