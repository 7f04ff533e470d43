"""The router: a router-mode session in a process of its own, doing what a stock `zenohd` would.

It relays between its clients, and between them and the routers it connects to. The process that
starts it learns the endpoint from the router itself, once it listens: so two fleets that start at once on one
host never take the same port.
"""

from __future__ import annotations

import json
import socket
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import replace

from protocol.bus.connection import Connection, configuration
from protocol.bus.zenoh import ZenohBus
from protocol.endpoint import DEFAULT_PORT, Endpoint
from protocol.errors import CertificateError, EndpointTakenError
from protocol.process.log import LOG
from protocol.process.signals import STOP

HOST = "127.0.0.1"
PORTS = range(DEFAULT_PORT, DEFAULT_PORT + 100)  # zenoh's own port and those after it
_HEAD = "// For zenohd 1.10 or newer: zenohd -c THIS_FILE. Whatever is not named here is zenoh's default.\n"


def main(
    connection: Connection,
    links: float = 0.0,
    ready: Callable[[str], None] | None = None,
) -> int:
    """Route until SIGTERM or SIGINT; `ready` is told the first endpoint as soon as it can be used.

    Without `connection.listen` the first free port from 7447 on 127.0.0.1 is taken. `links` is for
    how long (s) links to other routers are waited for before that; they come up in the background else.

    Raises:
        EndpointTakenError: the endpoint that was asked for is taken (and by which program), or every port is.
        CertificateError: another router does not accept this one's certificate, or the reverse.
        BusError: the endpoint cannot be listened on for another reason, or a link is waited for in vain.
        Stopped: a signal asks this process to end before it listens.
    """
    bus, endpoint = listening(connection)
    with closing(bus):
        _check_links(connection)
        if connection.credentials is None and not endpoint.is_loopback:
            LOG.warning(f"no keys at {endpoint}: any process that reaches it can take part in the run")
        if links > 0.0:
            bus.await_routers(links)
        if ready is not None:
            ready(str(endpoint))
        STOP.wait()
    return 0


def listening(connection: Connection) -> tuple[ZenohBus, Endpoint]:
    """Open a router session; returns it with the endpoint that it listens on."""
    if connection.listen:
        return _asked_for(connection), connection.listen[0]
    protocol = "tcp" if connection.credentials is None else "tls"
    for port in PORTS:
        endpoint = Endpoint.at(protocol, HOST, port)
        try:
            with reserved(endpoint):  # else another fleet's router is about to come back there
                pass
            return ZenohBus(replace(connection, listen=(endpoint,))), endpoint
        except (EndpointTakenError, OSError):
            continue
    raise EndpointTakenError(
        f"no free port on {HOST} from {PORTS.start} to {PORTS.stop - 1}: "
        f"stop another fleet, or name an endpoint to listen on"
    )


@contextmanager
def reserved(endpoint: Endpoint) -> Iterator[None]:
    """Keep an endpoint's port from processes that look for a free one, while its own router is not there.

    A socket for UDP, where no router listens, says so to other processes, and goes with this one.

    Raises:
        OSError: another process has reserved it.
    """
    address = endpoint.address
    assert address is not None, "only routers on a network look for ports"
    with socket.socket(socket.AF_INET6 if ":" in address[0] else socket.AF_INET, socket.SOCK_DGRAM) as place:
        place.bind(address)
        yield


def _check_links(connection: Connection) -> None:
    """Say that a router refuses this one: zenoh would go on trying without a word."""
    if connection.credentials is None:
        return
    from protocol.bus.diagnose import refusal  # only where it may be needed

    for endpoint in connection.connect:
        if (why := refusal(endpoint, connection.credentials)) is not None:
            raise CertificateError(why)


def _asked_for(connection: Connection) -> ZenohBus:
    try:
        return ZenohBus(connection)
    except EndpointTakenError as error:
        holders = "; ".join(filter(None, map(holder, connection.listen)))
        raise EndpointTakenError(
            f"cannot listen on {', '.join(connection.listen)}: taken{holders and f' by {holders}'}; "
            f"use that router, name another endpoint, or name none and a free port is taken"
        ) from error


def holder(endpoint: Endpoint) -> str:
    """The program that listens on the port of an endpoint, as far as this user may know; else empty."""
    import psutil  # only for this text: the router itself stays lean

    if endpoint.address is None:
        return ""
    try:
        for each in psutil.net_connections("inet"):
            if each.status == psutil.CONN_LISTEN and getattr(each.laddr, "port", 0) == endpoint.address[1]:
                if each.pid is None:
                    return "a process of another user"
                return f"{psutil.Process(each.pid).name()} (process {each.pid})"
    except psutil.Error:  # ended meanwhile, or this user may not look
        return ""
    return ""


def router_config(connection: Connection, default: Endpoint) -> str:
    """JSON5 by which `zenohd` relays, and enforces, exactly as `disknav node router` does.

    `default` is listened on where `connection` names no endpoint.
    """
    listening = connection if connection.listen else replace(connection, listen=(default,))
    return _HEAD + json.dumps(configuration(listening), indent=2) + "\n"
