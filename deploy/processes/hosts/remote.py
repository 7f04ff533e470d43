"""On another host: a fork server whose channel is an ssh connection; and facts about the host.

`disknav run --hosts` starts the fork server on each host. It prints a greeting, then receives requests on
standard input and sends news on standard output; logs go to standard error. It ends, with all its
processes, with the connection, or after a long time without a request. `disknav setup hosts` asks for the
facts.
"""

from __future__ import annotations

import os
import platform
import shutil
import socket
import sys
import tempfile
import time
from collections.abc import Sequence
from contextlib import ExitStack
from functools import partial
from multiprocessing.connection import Connection as Channel
from pathlib import Path
from typing import Any

import msgspec

from deploy.processes.fork_server import serve
from deploy.processes.spawn import MODULES, Store
from deploy.software import SOFTWARE, code_digest
from protocol.process import log

GREETING = "disknav-host"  # followed by a digest of the code, and the folder
_PATIENCE = 30.0  # s; the launcher sends a heartbeat every second


class Facts(msgspec.Struct, frozen=True):
    """Facts about a host."""

    code: str  # digest of this software's sources
    python: str
    compiled: bool
    free: int  # bytes, where a run's files go
    port: str  # error on listening on the router's port; empty if there is none


def main(modules: Sequence[str] = MODULES, patience: float = _PATIENCE, run: str = "") -> int:
    """Serve until the connection ends; returns the exit status."""
    requests: Channel[Any, Any] = Channel(os.dup(0), writable=False)
    news: Channel[Any, Any] = Channel(os.dup(1), readable=False)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.dup2(2, 1)  # keeps printed text out of the news
    folder = Path(tempfile.mkdtemp(prefix="disknav-"))  # mode 0700
    try:
        os.write(news.fileno(), f"{GREETING} {code_digest(SOFTWARE)} {folder}\n".encode())
        begin_log = partial(log.begin, run=run, wired=True)
        store = partial(_store, folder)
        serve(requests, news, modules, run, begin_log=begin_log, store=store, patience=patience)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return 0


def _store(folder: Path, file: Store) -> None:
    path = folder / Path(file.name).name
    if path.exists():
        return
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    with os.fdopen(descriptor, "wb") as stream:
        stream.write(file.content)


def tell_facts(listen: str, port: str) -> int:
    """Listen on the router's port, print the facts, then the time (s, monotonic) for each line of input."""
    with ExitStack() as stack:
        why = ""
        try:
            stack.enter_context(_listener(listen, int(port)))
        except OSError as error:
            why = str(error)
        import agents.robot

        facts = Facts(
            code_digest(SOFTWARE),
            platform.python_version(),
            not (agents.robot.__file__ or "").endswith(".py"),
            shutil.disk_usage(tempfile.gettempdir()).free,
            why,
        )
        print(msgspec.json.encode(facts).decode(), flush=True)
        for _ in sys.stdin:
            print(time.monotonic(), flush=True)
    return 0


def _listener(address: str, port: int) -> socket.socket:
    family = socket.AF_INET6 if ":" in address else socket.AF_INET
    return socket.create_server((address, port), family=family)


if __name__ == "__main__":
    given = sys.argv[1:]
    sys.exit(tell_facts(*given[1:]) if given[:1] == ["--facts"] else main(run="".join(given)))
