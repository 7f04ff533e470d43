"""The router: a session in router mode, in a process of its own; equivalent to a stock `zenohd`.

It relays between its clients and the routers it connects to. It reports its endpoint to its parent once it
listens, so two fleets that start at once on one host never use the same port.
"""

from __future__ import annotations

import json
import socket
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import replace

from protocol.bus.connection import DEFAULT_PORT, Connection, Endpoint, configuration
from protocol.bus.zenoh import ZenohBus
from protocol.errors import CertificateError, EndpointTakenError
from protocol.process.log import LOG
from protocol.process.signals import STOP

HOST = "127.0.0.1"
PORTS = range(DEFAULT_PORT, DEFAULT_PORT + 100)  # zenoh's default port and the following
_HEAD = "// For zenohd 1.10 or newer: zenohd -c THIS_FILE. All other settings are zenoh's defaults.\n"


def main(connection: Connection, links: float = 0.0, ready: Callable[[str], None] = lambda _: None) -> int:
    """Route until SIGTERM or SIGINT.

    Args:
        connection: endpoints and credentials; without `listen`, the first free port from 7447 on 127.0.0.1.
        links: time to wait for links to other routers, s; 0: they come up in the background.
        ready: called with the first endpoint as soon as it can be used.

    Raises:
        EndpointTakenError: the requested endpoint (with the program that uses it), or every port, is taken.
        CertificateError: another router refuses this one's certificate, or the reverse.
        BusError: listening fails for another reason, or a link is missing after `links` s.
        Stopped: a signal arrived before the router listened.
    """
    bus, endpoint = listening(connection)
    with closing(bus):
        _check_links(connection)
        if connection.credentials is None and not endpoint.is_loopback:
            LOG.warning(f"no keys at {endpoint}: any process that reaches it can take part in the run")
        if links > 0.0:
            bus.await_routers(links)
        ready(str(endpoint))
        STOP.wait()
    return 0


def listening(connection: Connection) -> tuple[ZenohBus, Endpoint]:
    """Open a router session; returns it with its endpoint."""
    if connection.listen:
        return _asked_for(connection), connection.listen[0]
    protocol = "tcp" if connection.credentials is None else "tls"
    for port in PORTS:
        endpoint = Endpoint.at(protocol, HOST, port)
        try:
            with reserved(endpoint):  # fails if another fleet's router is being restarted there
                pass
            return ZenohBus(replace(connection, listen=(endpoint,))), endpoint
        except (EndpointTakenError, OSError) as error:
            why = error
    raise EndpointTakenError(
        f"no free port on {HOST} from {PORTS.start} to {PORTS.stop - 1}, the last: {why}; "
        f"stop another fleet, or name an endpoint to listen on"
    )


@contextmanager
def reserved(endpoint: Endpoint) -> Iterator[None]:
    """Keep an endpoint's port free for its router while that restarts.

    A bound UDP socket, which no router uses, marks the port for other processes of this software. Raises
    OSError if another process has reserved it.
    """
    address = endpoint.address
    assert address is not None, "only routers on a network have ports"
    with socket.socket(socket.AF_INET6 if ":" in address[0] else socket.AF_INET, socket.SOCK_DGRAM) as place:
        place.bind(address)
        place.connect(address)  # fails at once if the loopback interface is down
        yield


def _check_links(connection: Connection) -> None:
    """Report a refused certificate, which zenoh would retry silently."""
    if connection.credentials is None:
        return
    from protocol.bus.diagnose import refusal

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
            f"join it with --router, or give another endpoint with --listen"
        ) from error


def holder(endpoint: Endpoint) -> str:
    """The program that listens on the port of an endpoint; empty if this user may not know."""
    import psutil  # only here, to keep the router's memory small

    if endpoint.address is None:
        return ""
    try:
        for each in psutil.net_connections("inet"):
            if each.status == psutil.CONN_LISTEN and getattr(each.laddr, "port", 0) == endpoint.address[1]:
                if each.pid is None:
                    return "a process of another user"
                return f"{psutil.Process(each.pid).name()} (process {each.pid})"
    except psutil.Error:  # the program has ended, or this user may not look
        return ""
    return ""


def router_config(connection: Connection, default: Endpoint) -> str:
    """JSON5 configuration with which `zenohd` acts exactly as `disknav node router` does.

    `default` is the endpoint to listen on if `connection` names none.
    """
    listening = connection if connection.listen else replace(connection, listen=(default,))
    return _HEAD + json.dumps(configuration(listening), indent=2) + "\n"
