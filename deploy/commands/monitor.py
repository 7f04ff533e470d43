"""`disknav monitor`: look at a running fleet from outside."""

from __future__ import annotations

import os
import signal
from contextlib import closing
from typing import Annotated

import typer

from deploy.commands import options
from deploy.monitor.source import SharedView, Source
from deploy.security.membership import Membership
from deploy.security.roster import MONITOR
from protocol.bus.connection import Connection
from protocol.errors import UsageError
from protocol.title import entitle

_TIMEOUT = 5.0  # s to reach somebody
_NICENESS = 10  # a fleet on the same machine first


def monitor(
    run: options.RunName = None,
    router: Annotated[
        list[str] | None,
        typer.Option(
            metavar="ENDPOINT",
            help="Where the fleet's router listens; tcp/127.0.0.1:7447 unless given (tls/ if --secure). "
            "Repeat it for each process of a mesh.",
        ),
    ] = None,
    web: Annotated[bool, typer.Option("--web", help="Serve the live page; its address is printed.")] = False,
    secure: options.Secure = None,
    metrics: Annotated[
        str | None,
        typer.Option(metavar="[ADDRESS:]PORT", help="Serve figures for Prometheus; 127.0.0.1 unless given."),
    ] = None,
    port: Annotated[
        int | None, typer.Option(min=1, max=65535, help="Port of the page; a free one unless given.")
    ] = None,
) -> None:
    """Watch a running fleet: a table in the terminal, or a live page with [b]--web[/b]. Ctrl-C ends it.

    The fleet does not notice: what this monitor cannot keep up with is dropped, never waited for.
    The run may begin later. The table ends with the run; page and metrics stay until Ctrl-C.

    Example: disknav monitor --router tcp/10.0.0.1:7447 --run demo --web

    Exit status: 0 the run ended while it was watched, or Ctrl-C; 2 invalid; 3 nobody listens at the endpoint.
    """
    from deploy.monitor.attachment import attach

    if not web:
        options.refuse({"--port": port}, "it is the port of the live page: add --web")
    if secure is not None and len(router or ()) > 1:
        options.refuse({"--router": router}, "with --secure there is one router")
    os.nice(_NICENESS)
    membership = Membership(secure)
    name = membership.run(run)
    if name is None:
        raise UsageError("name the run: --run NAME, which the fleet's launcher prints")
    entitle("monitor", name)
    role = membership.viewer if web else MONITOR
    with closing(attach(_connection(router, membership, role), name)) as source:
        try:
            if metrics is not None:
                _export(source, metrics, until_signal=not web)
            if web:
                _serve(source, port)
            elif metrics is None:
                from deploy.monitor.terminal import show

                show(source)
        except KeyboardInterrupt:
            pass


def _connection(endpoints: list[str] | None, membership: Membership, role: str) -> Connection:
    """A router relays everything; the processes of a mesh relay nothing, so each needs a link."""
    if endpoints is None or len(endpoints) == 1 or membership.directory is not None:
        return membership.client(role, endpoints or (membership.default_router,), timeout=_TIMEOUT)
    return Connection("peer", connect=tuple(endpoints), timeout=_TIMEOUT)


def _export(source: SharedView, where: str, *, until_signal: bool) -> None:
    from deploy.monitor.metrics import export

    print(f"{export(source, where)}  (Ctrl-C ends it)", flush=True)
    if until_signal:
        signal.pause()


def _serve(source: Source, port: int | None) -> None:
    from deploy.monitor.web.server import serve_in_thread

    with closing(serve_in_thread(source, port)) as server:
        print(f"{server.link}  (Ctrl-C ends it)", flush=True)
        signal.pause()
