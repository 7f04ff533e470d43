"""The live page beside a run: as the fleet goes, and as its viewer steers it."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from deploy.run.fleet import Fleet
from deploy.run.local import LocalFleet
from deploy.run.options import RunOptions
from deploy.telemetry.monitor.watcher import Attachment, Watcher
from protocol.bus.zenoh import ZenohBus
from protocol.process.signals import STOP


def linger(link: str) -> None:
    """Stay after the run until Ctrl-C, so that the end of a page can be looked at."""
    print(f"{link} stays until Ctrl-C", file=sys.stderr, flush=True)
    STOP.wait()


@contextmanager
def live_page(fleet: Fleet | LocalFleet, options: RunOptions) -> Iterator[str]:
    """Serve a page that shows `fleet`; gives its address, and prints it to standard error: whoever opens it
    may steer.

    Raises:
        UsageError: the libraries of the extra `web` are not installed.
    """
    from deploy.telemetry.monitor.web.server import serve_in_thread

    source = _watch(fleet, options.run)
    server = serve_in_thread(source)
    print(f"live page: {server.link}", file=sys.stderr, flush=True)
    try:
        yield server.link
    finally:
        server.close()
        if isinstance(source, Attachment):
            source.close()


def _watch(fleet: Fleet | LocalFleet, run: str) -> Watcher:
    if isinstance(fleet, Fleet):
        return Attachment(ZenohBus(fleet.topology.viewer()), run)
    bus = fleet.network.connect()
    watcher = bus.node = Watcher(bus, run)
    return watcher
