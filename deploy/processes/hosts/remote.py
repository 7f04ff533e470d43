"""On another host: a fork server whose channel is an ssh connection.

It prints a greeting, then receives requests on standard input and sends news on standard output; logs go to
standard error. It ends, with all its processes, with the connection, or after a long time without a request.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from functools import partial
from multiprocessing.connection import Connection as Channel
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from deploy.processes.fork_server import ForkServer
from deploy.processes.spawn import MODULES, Store
from deploy.software import SOFTWARE, code_digest
from protocol.process import log

GREETING = "disknav-host"  # followed by a digest of the code, and the folder
_PATIENCE = 30.0  # s; the launcher sends a heartbeat every second


def main(modules: Sequence[str] = MODULES, patience: float = _PATIENCE, run: str = "") -> int:
    """Serve until the connection ends; returns the exit status."""
    requests: Channel[Any, Any] = Channel(os.dup(0), writable=False)
    news: Channel[Any, Any] = Channel(os.dup(1), readable=False)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.dup2(2, 1)  # keeps printed text out of the news
    with TemporaryDirectory(prefix="disknav-", ignore_cleanup_errors=True) as folder:  # mode 0700
        os.write(news.fileno(), f"{GREETING} {code_digest(SOFTWARE)} {folder}\n".encode())
        begin_log = partial(log.begin, run=run, wired=True)
        store = partial(_store, Path(folder))
        server = ForkServer(requests, news, modules, run, begin_log=begin_log, store=store, patience=patience)
        server.serve()
    return 0


def _store(folder: Path, file: Store) -> None:
    path = folder / Path(file.name).name
    if path.exists():
        return
    path.touch(0o600, exist_ok=False)
    path.write_bytes(file.content)


if __name__ == "__main__":
    sys.exit(main(run="".join(sys.argv[1:])))
