"""Endpoints: where a process listens, or is reached, in zenoh's words such as `tcp/127.0.0.1:7447`."""

from __future__ import annotations

import re
from ipaddress import IPv6Address
from typing import Final

from protocol.errors import UsageError

DEFAULT_PORT: Final = 7447  # zenoh's own
_PROTOCOLS = ("tcp", "tls")
_FORM = re.compile(
    r"(?:(?P<protocol>[a-z-]+)/)?"
    r"(?P<host>[A-Za-z0-9_](?:[A-Za-z0-9_.-]*[A-Za-z0-9_])?|\[(?P<v6>[0-9A-Fa-f:.]+)\])"
    r"(?::(?P<port>[0-9]{1,5}))?"
    r"(?P<options>(?:\?[a-z_]+=[A-Za-z0-9_.-]+)?(?:#[a-z_]+=[A-Za-z0-9_.:-]+)?)"
)
_SOCKET = re.compile(r"unixsock-stream/[^\x00-\x20\x7f?#\ud800-\udfff]+")
_HOW = "write PROTOCOL/HOST:PORT, such as tcp/127.0.0.1:7447 (an IPv6 address in brackets)"


class Endpoint(str):
    """An endpoint that zenoh understands: made from HOST, HOST:PORT or PROTOCOL/HOST:PORT.

    Raises:
        UsageError: it is none.
    """

    __slots__ = ()

    def __new__(cls, text: str, protocol: str = "tcp") -> Endpoint:
        """`protocol` is that of an endpoint which names none."""
        if isinstance(text, Endpoint) or _SOCKET.fullmatch(text):
            return str.__new__(cls, text)
        found = _FORM.fullmatch(text)
        if found is None:
            raise UsageError(f"{text!r} is no endpoint: {_HOW}")
        protocol, port = found["protocol"] or protocol, int(found["port"] or DEFAULT_PORT)
        if protocol not in _PROTOCOLS:
            raise UsageError(f"{text!r} is no endpoint of this software: its links are tcp/ or tls/; {_HOW}")
        if not 1 <= port <= 65535:
            raise UsageError(f"{text!r} is no endpoint: a port is a number from 1 to 65535")
        if found["v6"] is not None and not _is_address(found["v6"]):
            raise UsageError(f"{text!r} is no endpoint: {found['host']} is no IPv6 address")
        return str.__new__(cls, f"{protocol}/{found['host']}:{port}{found['options']}")

    @classmethod
    def at(cls, protocol: str, host: str, port: int) -> Endpoint:
        """The endpoint of a host, which may be an IPv6 address without brackets; raises UsageError."""
        return cls(f"{protocol}/[{host}]:{port}" if ":" in host else f"{protocol}/{host}:{port}")

    @property
    def protocol(self) -> str:
        """What its links speak."""
        return self.partition("/")[0]

    @property
    def address(self) -> tuple[str, int] | None:
        """Host (an IPv6 address without brackets) and port; None for a Unix socket."""
        found = _FORM.fullmatch(self)
        return None if found is None else (found["v6"] or found["host"], int(found["port"]))

    @property
    def is_loopback(self) -> bool:
        """Whether only processes of the same host reach it."""
        host = "" if self.address is None else self.address[0]
        return host in ("", "::1", "localhost") or host.startswith("127.")


def _is_address(text: str) -> bool:
    try:
        IPv6Address(text)
    except ValueError:
        return False
    return True
