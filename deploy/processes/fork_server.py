"""The process that all others are forked from, and that is their parent.

It imports what they need once (numpy, zenoh, the robots' modules) and opens no zenoh session, after
which forking would not be safe. A fork takes about a millisecond and shares the imported memory.
One channel joins it to the supervisor: requests come in, news of the processes go out. When the
channel ends, because the supervisor closed it or died in whatever way, all processes are killed.
"""

from __future__ import annotations

import gc
import importlib
import os
import signal
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from math import inf
from multiprocessing.connection import Connection as Channel
from multiprocessing.connection import wait
from pathlib import Path
from typing import Any

from deploy.processes.fork_messages import (
    Exited,
    News,
    Report,
    Request,
    Signal,
    Start,
    Started,
    Store,
    encode_news,
)
from deploy.processes.forked import run_forked
from protocol.process import log
from protocol.process.log import set_process_title
from protocol.process.signals import STOP


def main(channel: int, modules: Sequence[str], run: str = "", logs: str = "") -> None:
    """Serve one supervisor, on a socket inherited from it, until the other end is closed.

    `logs` is the folder for the files of the processes' logs; empty for none.
    """
    both: Channel[Any, Any] = Channel(channel)
    folder = Path(logs) if logs else None
    serve(both, both, modules, run, begin_log=partial(log.begin, run=run, folder=folder))


def serve(
    requests: Channel[Any, Request],
    news: Channel[bytes, Any],
    modules: Sequence[str],
    run: str = "",
    *,
    begin_log: Callable[[str], None],
    store: Callable[[Store], None] | None = None,
    patience: float = inf,
) -> None:
    """Serve one supervisor; leave no process behind.

    Args:
        requests: ends when the supervisor does.
        news: the way back; may be the same channel.
        modules: imported first.
        run: stands in the titles of this process and of those forked from it.
        begin_log: gives a forked process its log, by its name.
        store: takes files.
        patience: s without a request after which the supervisor counts as gone.
    """
    set_process_title("fork server", run)
    for module in modules:
        importlib.import_module(module)
    gc.collect()
    gc.freeze()  # else the collector writes to, and so copies, every page that is shared with the forks
    server = _Server(requests, news, run, begin_log, store, patience)
    try:
        with suppress(ConnectionError):  # nobody hears the news any more
            server.serve()
    finally:
        server.kill_all()


class _Server:
    def __init__(
        self,
        requests: Channel[Any, Request],
        news: Channel[bytes, Any],
        run: str,
        begin_log: Callable[[str], None],
        store: Callable[[Store], None] | None,
        patience: float,
    ) -> None:
        self._requests, self._news, self._run = requests, news, run
        self._begin_log = begin_log
        self._store, self._patience = store, patience
        self._heard = time.monotonic()
        self._lives: dict[int, int] = {}  # pid -> life, of those not yet waited for
        self._reports: dict[int, tuple[int, Channel[str, str]]] = {}  # descriptor -> life, its pipe
        self._lifeline, self._held = os.pipe()  # the forks' ends are at end of file when this process is gone
        self._signalled, written = os.pipe()  # a signal makes it readable
        os.set_blocking(written, False)
        STOP.listen()
        signal.signal(signal.SIGCHLD, lambda *_: None)
        signal.set_wakeup_fd(written, warn_on_full_buffer=False)

    def serve(self) -> None:
        requests = self._requests.fileno()
        while (remaining := self._heard + self._patience - time.monotonic()) > 0.0:
            for ready in wait([requests, self._signalled, *self._reports], min(remaining, 3600.0)):
                if ready == requests:
                    try:
                        self._obey(self._requests.recv())
                    except (EOFError, ConnectionError):
                        return
                elif ready == self._signalled:
                    os.read(self._signalled, 4096)
                    if STOP.requested:
                        return
                    self._collect()
                elif isinstance(ready, int) and ready in self._reports:  # else just collected
                    self._relay(ready)

    def kill_all(self) -> None:
        for pid in self._lives:
            os.kill(pid, signal.SIGKILL)
        for pid in self._lives:
            os.waitpid(pid, 0)

    def _tell(self, news: News) -> None:
        self._news.send_bytes(encode_news(news))

    def _obey(self, request: Request) -> None:
        self._heard = time.monotonic()
        if isinstance(request, Start):
            self._fork(request)
        elif isinstance(request, Store) and self._store is not None:
            self._store(request)
        elif isinstance(request, Signal):
            for pid, life in self._lives.items():
                if life == request.life:
                    os.kill(pid, request.number)

    def _fork(self, start: Start) -> None:
        reading, writing = os.pipe() if start.reports else (None, None)
        with STOP.held():  # what reaches the new process before Python is ready in it
            pid = os.fork()
        if pid == 0:
            run_forked(start, self._run, writing, self._lifeline, self._begin_log)
        if reading is not None and writing is not None:
            os.close(writing)
            self._reports[reading] = (start.life, Channel(reading, writable=False))
        self._lives[pid] = start.life
        self._tell(Started(start.life, pid))

    def _relay(self, descriptor: int) -> None:
        life, pipe = self._reports[descriptor]
        try:
            text = pipe.recv()
        except (EOFError, OSError):  # it has ended, perhaps in the middle of a report
            del self._reports[descriptor]
            pipe.close()
        else:
            self._tell(Report(life, text))

    def _collect(self) -> None:
        unit = 2**20 if sys.platform == "darwin" else 2**10  # ru_maxrss is in bytes there, in KiB here
        while self._lives:
            pid, status, usage = os.wait4(-1, os.WNOHANG)
            if pid == 0:
                return
            code = os.waitstatus_to_exitcode(status)
            cpu = usage.ru_utime + usage.ru_stime
            life = self._lives.pop(pid)
            self._relay_last(life)
            self._tell(Exited(life, code, cpu, usage.ru_maxrss / unit))

    def _relay_last(self, life: int) -> None:
        """What a process reported before it ended is told before its end."""
        for descriptor, (owner, pipe) in list(self._reports.items()):
            while owner == life and descriptor in self._reports and pipe.poll():
                self._relay(descriptor)
