"""`disknav monitor`: watch a running fleet."""

from __future__ import annotations

import os
from contextlib import ExitStack, closing
from importlib import import_module
from socket import AF_INET, AF_INET6, create_server
from typing import Annotated

import typer

from deploy.cli import options
from deploy.security.membership import KeyRing
from deploy.security.roster import MONITOR
from protocol.bus.connection import Connection, Endpoint
from protocol.errors import UsageError
from protocol.process.log import set_process_title
from protocol.process.signals import STOP

_TIMEOUT = 5.0  # s to reach the fleet
_SCENE = 8765  # Foxglove's default port
_NICENESS = 10  # a fleet on the same machine goes first


def monitor(
    run: Annotated[
        str | None, typer.Argument(metavar="RUN", help="Name of the run; optional with --secure.")
    ] = None,
    router: Annotated[
        list[str] | None,
        typer.Option(
            metavar="ENDPOINT",
            help="Endpoint at which the fleet's router listens; default tcp/127.0.0.1:7447 (tls/ with "
            "--secure). In a mesh one per process.",
        ),
    ] = None,
    web: options.Web = False,
    secure: options.Secure = None,
    foxglove: Annotated[
        bool, typer.Option("--foxglove", help="Serve a scene for Foxglove; its address is printed.")
    ] = False,
    metrics: Annotated[
        str | None,
        typer.Option(
            metavar="[ADDRESS:]PORT", help="Serve metrics for Prometheus; default address 127.0.0.1."
        ),
    ] = None,
    port: Annotated[
        int | None,
        typer.Option(
            min=1, max=65535, help="Port of the page, by default a free one; of --foxglove alone 8765."
        ),
    ] = None,
) -> None:
    """Watch a running fleet: a table in the terminal, a live page with [b]--web[/b], a scene in Foxglove with
    [b]--foxglove[/b]. Ctrl-C ends it.

    It never slows down the fleet: messages that it cannot keep up with are dropped. It may start before the
    run. The table ends with the run; page, scene and metrics stay until Ctrl-C.

    Example: disknav monitor demo --router tcp/10.0.0.1:7447 --web

    Exit status: 0 the run has ended, 2 invalid, 3 no router at the endpoint, 130 Ctrl-C.
    """
    from deploy.telemetry.monitor.watcher import Attachment
    from protocol.bus.zenoh import ZenohBus

    if not (web or foxglove):
        options.refuse({"--port": port}, "it is the port of the live page: add --web, or --foxglove")
    if secure is not None and len(router or ()) > 1:
        options.refuse({"--router": router}, "with --secure there is one router")
    scene = _SCENE if web or port is None else port
    wanted = {"web": str(port or 0) * web, "foxglove": str(scene) * foxglove, "metrics": metrics}
    for view, where in wanted.items():  # before there is a link to the run
        if where:
            _check(view, where)
    os.nice(_NICENESS)
    membership = KeyRing(secure)
    name = membership.named_run(run)
    set_process_title("monitor", name)
    role = membership.viewer if web else MONITOR
    connection = _connection(router, membership, role)
    with ExitStack() as stack:
        source = stack.enter_context(closing(Attachment(ZenohBus(connection), name)))
        if foxglove:
            from deploy.telemetry.monitor.foxglove import FoxgloveServer

            viewed = stack.enter_context(closing(FoxgloveServer(source, name, scene)))
            print(f"{viewed.address}  (open it in Foxglove)", flush=True)
        if metrics is not None:
            from deploy.telemetry.monitor.metrics import export

            print(f"{export(source, metrics)}  (Ctrl-C ends it)", flush=True)
        if web:
            from deploy.telemetry.monitor.web import Server

            server = stack.enter_context(closing(Server(source, port)))
            print(f"{server.link}  (Ctrl-C ends it)", flush=True)
        if web or foxglove or metrics is not None:
            STOP.wait()
        else:
            from deploy.telemetry.monitor.terminal import show

            show(source)


def _connection(endpoints: list[str] | None, membership: KeyRing, role: str) -> Connection:
    """One link to a router, which relays all messages; or one to each process of a mesh, which relay none."""
    if endpoints is None or len(endpoints) == 1 or membership.directory is not None:
        return membership.client(role, endpoints or (None,), timeout=_TIMEOUT)
    return Connection("peer", connect=tuple(map(Endpoint, endpoints)), timeout=_TIMEOUT)


def _check(view: str, where: str) -> None:
    """Raise UsageError for a missing library of a view, or an `[ADDRESS:]PORT` that it cannot listen at."""
    import_module(f"deploy.telemetry.monitor.{view}")
    host, _, number = where.rpartition(":")
    try:
        family = AF_INET6 if host.startswith("[") else AF_INET
        create_server((host.strip("[]") or "127.0.0.1", int(number)), family=family).close()
    except (OSError, ValueError, OverflowError) as error:
        option = "--metrics" if view == "metrics" else "--port"
        reason = getattr(error, "strerror", "") or "it is not [ADDRESS:]PORT"
        raise UsageError(f"{option}: cannot listen at {where}: {reason}; give a free PORT") from error
