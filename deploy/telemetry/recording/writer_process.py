"""A recording that is written by a process of its own: those who hear hand over what they hear, and may die
and come back; whoever started it hands over the result, with which the file ends.

Hearing costs next to nothing so, and the file is written by another processor: see
`python -m tests.benchmarks.recording.recorder`.
"""

from __future__ import annotations

import multiprocessing
import os
import socket
from collections.abc import Callable, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection as Pipe
from multiprocessing.connection import wait
from pathlib import Path
from typing import Any

import msgspec

from deploy.telemetry.recording.parts import Parts, Rotation, next_free
from protocol.errors import DisknavError, RecordingError, UsageError
from protocol.process.beside import ForkedBeside
from protocol.process.log import set_process_title
from protocol.process.signals import STOP
from protocol.scenario.model import Scenario

_PATIENCE = 30.0  # s that the other process may take to open or to finish the file
_GONE = (EOFError, OSError)  # in the middle of a message, too
_NICENESS = 10  # the fleet first, and yet a share of a busy machine
_pack = msgspec.msgpack.encode  # cheaper than pickling each pair
_UNPACK = msgspec.msgpack.Decoder(list[tuple[str, bytes]])


class Writer:
    """What `Parts` does, done elsewhere: this process only hands messages over.

    If this process dies, all that it handed over is still written. If the other one dies, the next call
    looks for the one that has taken its place.

    Raises:
        RecordingError: (all methods) there is nobody who writes.
    """

    def __init__(self, path: Path, connect: Callable[[], Pipe]) -> None:
        self.path, self._connect = path, connect
        self._pipe: Pipe | None = None
        self._begun: tuple[str, Scenario] | None = None

    @classmethod
    def at(cls, address: Path, path: Path | None = None) -> Writer:
        """The process that `main` runs at an address; `path`, for messages, is what it writes."""

        def connect() -> Pipe:
            with socket.socket(socket.AF_UNIX) as client:
                client.connect(str(address))
                return Pipe(client.detach())

        return cls(path or address, connect)

    def begin(self, run: str, scenario: Scenario) -> None:
        """See `Parts.begin`."""
        self._begun = run, scenario
        self._ask("begin", run, scenario)

    def write(self, batch: Sequence[tuple[str, bytes]]) -> None:
        """See `Parts.write`."""
        self._ask("write", _pack(batch))

    def flush(self) -> None:
        """See `Parts.flush`."""
        self._ask("flush")

    def report(self, result: str) -> None:
        """See `Parts.report`."""
        self._ask("report", result)

    def finish(self, result: str | None = None) -> None:
        """See `Parts.finish`."""
        self._ask("finish", result)
        if failed := self._answer():
            raise RecordingError(failed)

    def _ask(self, method: str, *arguments: Any) -> None:
        try:
            if self._pipe is None:
                self._pipe = self._connect()
                if self._begun is not None:
                    self._pipe.send(("begin", self._begun))
            self._pipe.send((method, arguments))
        except OSError as error:
            failed, self._pipe = self._answer(), None
            raise RecordingError(failed or self._silence) from error

    def _answer(self) -> str:
        """What went wrong over there; empty if nothing did."""
        try:
            if self._pipe is not None and self._pipe.poll(_PATIENCE):
                return str(self._pipe.recv())
        except (EOFError, OSError):
            pass  # told below: who writes is gone without a word
        return self._silence

    @property
    def _silence(self) -> str:
        return (
            f"cannot go on recording to {self.path}: the process that writes it is gone, or does not answer"
        )


class WriterProcess(Writer):
    """One that is forked from this process, for it alone: at once, and with everything imported already.

    Raises:
        UsageError: the file cannot be created.
    """

    def __init__(self, path: Path, run: str = "") -> None:
        pipe, other = multiprocessing.Pipe()
        super().__init__(path, lambda: pipe)
        self._process = ForkedBeside(_PATIENCE, _forked, (pipe, other, path, run))
        with STOP.held():  # this process ends the other one, by finishing
            self._process.start()
        other.close()
        self._pipe = pipe
        try:
            if refused := self._answer():
                raise UsageError(refused)
        except BaseException:  # nobody has the writer, to close it
            self.close()
            raise

    def finish(self, result: str | None = None) -> None:
        """See `Parts.finish`."""
        try:
            super().finish(result)
        finally:
            self.close()

    def close(self) -> None:
        """End the other process, which writes what it was told; in vain, it is killed."""
        if self._pipe is not None:
            self._pipe.close()
        self._process.join()


def main(path: Path, address: Path, rotation: Rotation, ready: Callable[[str], None]) -> int:
    """Write what is handed over at `address` until told to finish, or SIGTERM, which finishes too.

    One that takes the place of another that was killed leaves that one's file as it is, and writes to the
    next name that is free, `run-2.mcap` beside `run.mcap`. `ready` is told the name of every file.

    Raises:
        UsageError: the file cannot be created.
    """
    pipes: list[Pipe] = []
    with STOP.readable() as stopped, socket.socket(socket.AF_UNIX) as door:
        path = next_free(path) if address.exists() else path
        address.unlink(missing_ok=True)
        door.bind(str(address))
        door.listen()
        file = Parts(path, rotation, ready)
        if not _serve(file, pipes, door, stopped):
            _take_rest(file, pipes)
            file.finish()
    return 0


def _forked(inherited: Pipe, pipe: Pipe, path: Path, run: str) -> None:
    """Do as told until the file is finished, or whoever tells is gone."""
    set_process_title("writer", run)
    inherited.close()
    os.nice(_NICENESS)
    try:
        file = Parts(path)
        pipe.send("")
        _serve(file, [pipe])
        file.abandon("the process that recorded is gone")  # unless it is finished
    except DisknavError as error:
        pipe.send(str(error))


def _serve(
    file: Parts, pipes: list[Pipe], door: socket.socket | None = None, stopped: int | None = None
) -> bool:
    """Obey all who are connected: until one has the file finished, which is returned, or `stopped` is
    readable, or nobody is left."""
    others = [each for each in (door, stopped) if each is not None]
    while pipes or door is not None:
        for ready in wait([*pipes, *others]):
            if ready == stopped:
                return False
            if isinstance(ready, socket.socket):
                if not pipes:
                    os.nice(max(0, _NICENESS - os.nice(0)))  # not before: one that only closes is not to wait
                pipes.append(Pipe(ready.accept()[0].detach()))
            elif isinstance(ready, Pipe) and ready in pipes and _obey(file, ready, pipes):
                return True
    return False


def _obey(file: Parts, pipe: Pipe, pipes: list[Pipe]) -> bool:
    """Do what one connection says next; whether the file is finished by that."""
    try:
        method, arguments = pipe.recv()
    except _GONE:
        pipes.remove(pipe)
        file.flush()  # what has been said is kept, whatever comes
        return False
    if method == "finish":
        _take_rest(file, [other for other in pipes if other is not pipe])
    _call(file, method, arguments)
    if method == "finish":
        pipe.send("")
    return bool(method == "finish")


def _take_rest(file: Parts, pipes: list[Pipe]) -> None:
    """Do what is still to be read of those who have handed over all."""
    for pipe in pipes:
        with suppress(*_GONE):
            while pipe.poll():
                _call(file, *pipe.recv())


def _call(file: Parts, method: str, arguments: Sequence[Any]) -> None:
    getattr(file, method)(*(map(_UNPACK.decode, arguments) if method == "write" else arguments))
