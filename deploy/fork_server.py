"""The process that all others are forked from, and that is their parent.

It imports what they need once (numpy, zenoh, the robots' modules) and opens no zenoh session, after
which forking would not be safe. A fork takes about a millisecond and shares the imported memory.
One channel joins it to the supervisor: requests come in, news of the processes go out. When the
channel ends, because the supervisor closed it or died in whatever way, all processes are killed.

Started by `deploy.spawn`. It and its processes are a session of their own, so a terminal's Ctrl-C
reaches the supervisor alone.
"""

from __future__ import annotations

import gc
import importlib
import os
import signal
import sys
from collections.abc import Sequence
from multiprocessing.connection import Connection as Channel
from multiprocessing.connection import wait
from pathlib import Path
from typing import Any, NamedTuple

FAULT = 3  # exit status of a process that an exception ended


class Start(NamedTuple):
    """Request: fork a process that calls `entry` ("module:function") with `arguments`.

    `reports`: the function gets one more argument, a callable that sends text to the supervisor.
    """

    life: int  # names this one process, for ever
    name: str
    entry: str
    arguments: tuple[Any, ...]
    reports: bool
    log: Path | None  # where its output goes; the terminal unless given


class Signal(NamedTuple):
    """Request: send a signal. To a process that has ended, nothing is sent."""

    life: int
    number: int


class Started(NamedTuple):
    """News: the process exists."""

    life: int
    pid: int


class Report(NamedTuple):
    """News: the process says something."""

    life: int
    text: str


class Exited(NamedTuple):
    """News: the process is gone; the exit code is negative for a signal."""

    life: int
    code: int
    cpu_s: float
    max_rss_mb: float


Request = Start | Signal
News = Started | Report | Exited


def main(channel_descriptor: int, modules: Sequence[str]) -> None:
    """Serve one supervisor until its end of the channel is closed."""
    for module in modules:
        importlib.import_module(module)
    gc.collect()
    gc.freeze()  # the collector would write to, and so copy, every shared page
    channel: Channel[News, Request] = Channel(channel_descriptor)
    server = _Server(channel)
    try:
        server.serve()
    finally:
        server.kill_all()


class _Server:
    def __init__(self, channel: Channel[News, Request]) -> None:
        self._channel = channel
        self._pids: dict[int, int] = {}  # life -> pid of those not yet waited for
        self._reports: dict[Channel[str, str], int] = {}  # reading end -> life
        # SIGCHLD interrupts nothing; it makes one end of a pipe readable.
        self._child_ended, written = os.pipe()
        os.set_blocking(written, False)
        signal.signal(signal.SIGCHLD, lambda *_: None)
        signal.set_wakeup_fd(written, warn_on_full_buffer=False)

    def serve(self) -> None:
        while True:
            for ready in wait([self._channel, self._child_ended, *self._reports]):
                if ready is self._channel:
                    try:
                        request = self._channel.recv()
                    except (EOFError, ConnectionError):
                        return
                    self._obey(request)
                elif ready == self._child_ended:
                    os.read(self._child_ended, 4096)
                    self._collect()
                elif isinstance(ready, Channel) and ready in self._reports:
                    self._relay(ready)

    def kill_all(self) -> None:
        for pid in self._pids.values():
            os.kill(pid, signal.SIGKILL)
        for pid in self._pids.values():
            os.waitpid(pid, 0)

    def _obey(self, request: Request) -> None:
        if isinstance(request, Start):
            self._fork(request)
        elif (pid := self._pids.get(request.life)) is not None:
            os.kill(pid, request.number)

    def _fork(self, start: Start) -> None:
        reading, writing = os.pipe()
        pid = os.fork()
        if pid == 0:
            os.close(reading)
            _become(start, writing)
        os.close(writing)
        self._pids[start.life] = pid
        self._reports[Channel(reading, writable=False)] = start.life
        self._channel.send(Started(start.life, pid))

    def _relay(self, pipe: Channel[str, str]) -> None:
        try:
            self._channel.send(Report(self._reports[pipe], pipe.recv()))
        except EOFError:
            del self._reports[pipe]
            pipe.close()

    def _collect(self) -> None:
        for life, pid in list(self._pids.items()):
            found, status, usage = os.wait4(pid, os.WNOHANG)
            if found:
                del self._pids[life]
                mega = 2**20 if sys.platform == "darwin" else 2**10  # ru_maxrss is bytes there, KiB here
                self._channel.send(
                    Exited(
                        life,
                        os.waitstatus_to_exitcode(status),
                        usage.ru_utime + usage.ru_stime,
                        usage.ru_maxrss / mega,
                    )
                )
