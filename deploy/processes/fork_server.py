"""The fork server: parent of all processes of a fleet; and the start of a forked process.

It imports the libraries of all processes once (numpy, zenoh, the robots' modules), and opens no zenoh
session, which would make forking unsafe. A fork takes about a millisecond and shares the imported memory.
Requests from the supervisor and news to it use one channel. When the channel ends, for whatever reason, all
processes are killed.
"""

from __future__ import annotations

import ctypes
import gc
import importlib
import os
import platform
import shutil
import signal
import socket
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from math import inf
from multiprocessing.connection import Connection as Channel
from multiprocessing.connection import wait
from pathlib import Path
from typing import Any, NoReturn

from deploy.processes.spawn import (
    Exited,
    HostFacts,
    Look,
    News,
    Process,
    ProcessReport,
    Request,
    Signal,
    Start,
    Started,
    Store,
    encode_news,
    stay_on,
)
from protocol.errors import DisknavError
from protocol.process import log
from protocol.process.log import LOG, set_process_title
from protocol.process.signals import STOP, Stopped

FAULT = 3  # exit status after an exception
_PR_SET_PDEATHSIG = 1  # <linux/prctl.h>
_LIBC = ctypes.CDLL(None)


def run_forked(
    process: Process,
    run: str,
    report: int | None,
    lifeline: int,
    parent: int,
    begin_log: Callable[[str], None],
) -> NoReturn:
    """Run the entry function of `process` in this newly forked process, and exit.

    Args:
        report: writing end of a pipe for text to the supervisor, if any.
        lifeline: reading end of a pipe that ends with the fork server.
        parent: process id of the fork server.
        begin_log: starts the log of a process, by its name.

    The exit status is the function's result, 0 after a signal, 3 after an exception.
    """
    code = FAULT
    try:
        set_process_title(process.name.replace("-", " ", 1), run)
        signal.set_wakeup_fd(-1)
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
        _close_all_but({report, lifeline})
        _end_with_parent(lifeline, parent)
        os.dup2(2, 1)  # standard output is reserved for the command
        begin_log(process.name)
        LOG.info(f"process {os.getpid()} begins")
        if process.core is not None:
            stay_on(process.core)  # before other threads start
        module, _, function = process.entry.partition(":")
        arguments = process.arguments
        if report is not None:
            arguments = (*arguments, Channel(report, readable=False).send)
        code = getattr(importlib.import_module(module), function)(*arguments)
    except Stopped:
        code = 0
    except SystemExit as ending:
        code = ending.code if isinstance(ending.code, int) else FAULT
    except DisknavError as error:
        LOG.error(error)
    except BaseException:  # noqa: BLE001  no caller is left to report it
        LOG.exception("failed:")
    finally:
        try:
            LOG.info("ends with status %s", code)
            sys.stderr.flush()
            sys.stdout.flush()
        finally:  # the reader may be gone
            # Do not return into the fork server's loop, and do not wait for threads.
            os._exit(code if isinstance(code, int) else FAULT)


def end_with_pipe(lifeline: int) -> None:
    """Kill this process from a thread at the end of a pipe. Portable, but not while it is stopped."""

    def watch() -> None:
        os.read(lifeline, 1)
        os.kill(os.getpid(), signal.SIGKILL)

    threading.Thread(target=watch, name="lifeline", daemon=True).start()


def _end_with_parent(lifeline: int, parent: int) -> None:
    if sys.platform == "linux":
        # Done by the kernel: needs no thread, and also kills a stopped process.
        if _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL) != 0:
            raise OSError("prctl(PR_SET_PDEATHSIG) failed")
        if os.getppid() != parent or _ended(lifeline):  # the parent died before that
            os._exit(FAULT)
    else:
        end_with_pipe(lifeline)


def _ended(pipe: int) -> bool:
    os.set_blocking(pipe, False)
    try:
        return os.read(pipe, 1) == b""
    except BlockingIOError:
        return False


def _close_all_but(kept: set[int | None]) -> None:
    """Close inherited descriptors except the standard streams: a copy of a pipe would keep it open."""
    for descriptor in [int(each.name) for each in Path("/dev/fd").iterdir()]:
        if descriptor > 2 and descriptor not in kept:
            with suppress(OSError):  # the descriptor of the listing is closed already
                os.close(descriptor)


def main(channel: int, modules: Sequence[str], run: str = "", logs: str = "") -> None:
    """Serve a supervisor on an inherited socket until the other end is closed.

    `logs` is the folder of the processes' log files; empty for none.
    """
    both: Channel[Any, Any] = Channel(channel)
    begin_log = partial(log.begin, run=run, folder=Path(logs) if logs else None)
    ForkServer(both, both, modules, run, begin_log=begin_log).serve()


class ForkServer:
    """Serves a supervisor, and kills all processes at the end.

    Args:
        requests, news: channels from and to the supervisor; may be the same.
        modules: to import before the first fork.
        begin_log: starts the log of a forked process, by its name.
        store: writes a received file.
        patience: s without a request after which the supervisor is considered dead.
    """

    def __init__(
        self,
        requests: Channel[Any, Request],
        news: Channel[bytes, Any],
        modules: Sequence[str],
        run: str = "",
        *,
        begin_log: Callable[[str], None],
        store: Callable[[Store], None] | None = None,
        patience: float = inf,
    ) -> None:
        set_process_title("fork server", run)
        for module in modules:
            importlib.import_module(module)
        gc.collect()
        gc.freeze()  # otherwise the collector would write to, and so copy, all pages shared with forks
        self._requests, self._news, self._run = requests, news, run
        self._begin_log = begin_log
        self._store, self._patience = store, patience
        self._heard = time.monotonic()
        self._listener: socket.socket | None = None  # on the router's port
        self._lives: dict[int, int] = {}  # pid -> process number, of processes not yet waited for
        self._reports: dict[int, tuple[int, Channel[str, str]]] = {}  # descriptor -> process number, pipe
        self._lifeline, self._held = os.pipe()  # forks read its end of file when this process is gone
        self._signalled, written = os.pipe()  # a signal makes it readable
        os.set_blocking(written, False)
        STOP.listen()
        signal.signal(signal.SIGCHLD, lambda *_: None)
        signal.set_wakeup_fd(written, warn_on_full_buffer=False)

    def serve(self) -> None:
        """Serve until the supervisor is gone; on another host also until a signal arrives."""
        try:
            with suppress(ConnectionError):
                self._serve()
        finally:
            for pid in self._lives:
                os.kill(pid, signal.SIGKILL)
            for pid in self._lives:
                os.waitpid(pid, 0)

    def _serve(self) -> None:
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
                    if STOP.requested and self._patience < inf:  # here it may have been sent to all
                        return
                    self._collect()
                elif isinstance(ready, int) and ready in self._reports:  # not collected just now
                    self._relay(ready)

    def _send(self, news: News) -> None:
        self._news.send_bytes(encode_news(news))

    def _obey(self, request: Request) -> None:
        self._heard = time.monotonic()
        if isinstance(request, Start):
            self._fork(request)
        elif isinstance(request, Look):
            self._send(self._facts(request))
        elif isinstance(request, Store) and self._store is not None:
            self._store(request)
        elif isinstance(request, Signal):
            for pid, life in self._lives.items():
                if life == request.life:
                    os.kill(pid, request.number)

    def _facts(self, look: Look) -> HostFacts:
        """Facts about this host; from the first request on it listens on the router's port."""
        import agents.robot

        why = ""
        if self._listener is None:
            family = socket.AF_INET6 if ":" in look.listen else socket.AF_INET
            try:
                self._listener = socket.create_server((look.listen, look.port), family=family)
            except OSError as error:
                why = str(error)
        compiled = not (agents.robot.__file__ or "").endswith(".py")
        free = shutil.disk_usage(tempfile.gettempdir()).free
        return HostFacts(0, platform.python_version(), compiled, free, why, time.monotonic())

    def _fork(self, start: Start) -> None:
        reading, writing = os.pipe() if start.process.reports else (None, None)
        parent = os.getpid()
        with STOP.held():  # signals that arrive before Python is ready in the new process
            pid = os.fork()
        if pid == 0:
            run_forked(start.process, self._run, writing, self._lifeline, parent, self._begin_log)
        if reading is not None and writing is not None:
            os.close(writing)
            self._reports[reading] = (start.life, Channel(reading, writable=False))
        self._lives[pid] = start.life
        self._send(Started(start.life, pid))

    def _relay(self, descriptor: int) -> None:
        life, pipe = self._reports[descriptor]
        try:
            text = pipe.recv()
        except (EOFError, OSError):  # the process has ended, perhaps within a report
            del self._reports[descriptor]
            pipe.close()
        else:
            self._send(ProcessReport(life, text))

    def _collect(self) -> None:
        unit = 1 if sys.platform == "darwin" else 2**10  # bytes, of ru_maxrss
        while self._lives:
            pid, status, usage = os.wait4(-1, os.WNOHANG)
            if pid == 0:
                return
            code = os.waitstatus_to_exitcode(status)
            cpu = usage.ru_utime + usage.ru_stime
            life = self._lives.pop(pid)
            for descriptor, (owner, pipe) in list(self._reports.items()):
                while owner == life and descriptor in self._reports and pipe.poll():
                    self._relay(descriptor)
            self._send(Exited(life, code, cpu, usage.ru_maxrss * unit / 1e6))
