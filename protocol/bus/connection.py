"""How a process reaches the network: endpoints in zenoh's words, such as `tcp/127.0.0.1:7447`; a plain
description with the files that prove its role; and the zenoh configuration that it stands for.

The directory of keys, which `disknav setup keys` fills, has `ca.pem`, the authority that all processes of a
run trust, and for each role `ROLE.pem`, its certificate, and `ROLE.key`, its private key. A host needs no
more of it than `ca.pem` and the pairs of the roles that run there.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from ipaddress import IPv6Address, ip_address
from pathlib import Path
from typing import Any, Final, Literal

from protocol.errors import CertificateError, UsageError

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
    """A zenoh endpoint from HOST, HOST:PORT or PROTOCOL/HOST:PORT; raises UsageError for any other text."""

    __slots__ = ()

    def __new__(cls, text: str, protocol: str = "tcp") -> Endpoint:
        """`protocol` is the default."""
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
        """Protocol of its links."""
        return self.partition("/")[0]

    @property
    def address(self) -> tuple[str, int] | None:
        """Host (an IPv6 address without brackets) and port; None for a Unix socket."""
        found = _FORM.fullmatch(self)
        return None if found is None else (found["v6"] or found["host"], int(found["port"]))

    @property
    def is_loopback(self) -> bool:
        """Whether only processes of the same host reach it."""
        return self.address is None or is_loopback(self.address[0])


def is_loopback(host: str) -> bool:
    """Whether a host's name or address is that of the loopback."""
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def _is_address(text: str) -> bool:
    try:
        IPv6Address(text)
    except ValueError:
        return False
    return True


AUTHORITY = "ca.pem"
MAX_MESSAGE = 8 * 1024 * 1024  # bytes; the largest payload that `protocol.keys` accepts


@dataclass(frozen=True, slots=True)
class Credentials:
    """One role's files, as absolute paths (PEM)."""

    authority: str
    certificate: str
    key: str


def certificate_file(role: str) -> str:
    """Name of a role's certificate."""
    return f"{role}.pem"


def key_file(role: str) -> str:
    """Name of a role's private key."""
    return f"{role}.key"


def credentials(directory: Path, role: str) -> Credentials:
    """The certificate and key of `role` in `directory`.

    Raises CertificateError if a file is missing, or if the private key may be read by others than its owner,
    or than a group if it is root's, as orchestrators pass keys to processes.
    """
    paths = [directory.absolute() / name for name in (AUTHORITY, certificate_file(role), key_file(role))]
    for path in paths:
        if not path.is_file():
            raise CertificateError(
                f"{path} does not exist, so there is no certificate for {role}; "
                f"`disknav setup keys` makes one for each role of a run"
            )
    status = paths[2].stat()
    if exposed := status.st_mode & (0o037 if status.st_uid == 0 else 0o077):
        raise CertificateError(
            f"{paths[2]} is a private key that others can reach (mode bits {exposed:03o}): "
            f"chmod 600 it, or better make new keys"
        )
    return Credentials(*map(str, paths))


@dataclass(frozen=True, slots=True)
class Connection:
    """One process's place in the network.

    A `client` reaches all others through one of `connect`; a `router` relays between its clients and the
    routers in `connect`; a `peer` has a direct link to each endpoint in `connect` and relays nothing, so
    every two peers need their own link. A client needs one of its endpoints, a peer the first: other links
    may come up later, so that a peer may start while another is down.

    Raises UsageError if `connect` or `listen` contains an invalid endpoint.
    """

    mode: Literal["client", "router", "peer"] = "client"
    connect: tuple[Endpoint, ...] = ()
    listen: tuple[Endpoint, ...] = ()
    timeout: float = 20.0  # s, how long opening tries to reach `connect`
    lease: float = 2.0  # s, silence after which others consider this process lost
    credentials: Credentials | None = None  # certificates of `tls/` endpoints, at both ends
    access: Mapping[str, Any] | None = None  # a router's rules, zenoh's `access_control`
    admin: bool = False  # whether a router shows its links and declarations in zenoh's admin space

    def __post_init__(self) -> None:
        object.__setattr__(self, "connect", tuple(map(Endpoint, self.connect)))
        object.__setattr__(self, "listen", tuple(map(Endpoint, self.listen)))


def configuration(connection: Connection, attempt: float | None = None) -> Mapping[str, Any]:
    """zenoh's configuration for `connection`: the settings that differ from its defaults, with reasons.

    `attempt` (s) bounds one attempt to open; by default the whole of `connection.timeout`.
    """
    wait = connection.timeout if attempt is None else attempt
    access = {} if connection.access is None else {"access_control": connection.access}
    return {
        **access,
        "mode": connection.mode,
        "connect": {
            "endpoints": _endpoints(connection),
            # By default a client fails at once if its router is not up yet.
            "timeout_ms": round(1000 * wait),
            # A router or a further peer retries unreachable endpoints in the background.
            "exit_on_failure": connection.mode == "client",
            # A restarted router is found again within 0.1 s (1.5 s by default).
            "retry": {"period_init_ms": 100, "period_max_ms": 400, "period_increase_factor": 2},
        },
        # An endpoint in use is an error at once.
        "listen": {"endpoints": list(connection.listen), "timeout_ms": 0, "exit_on_failure": True},
        # Endpoints are explicit, without scouting or gossip.
        "scouting": {"delay": 0, "multicast": {"enabled": False}, "gossip": {"enabled": False}},
        # `get('@/**')` under many declarations can deadlock a router for good, so it is off by default.
        "adminspace": {"enabled": connection.admin, "permissions": {"read": True, "write": False}},
        # Ticks are in the messages; a router would stamp every sample with the wall clock.
        "timestamping": {"enabled": {"router": False, "peer": False, "client": False}},
        "transport": {
            "unicast": {
                "accept_pending": 1000,  # a fleet connects all at once (default 100)
                "open_timeout": 2000,  # closing waits for an attempt to reach a frozen router (default 10 s)
            },
            "shared_memory": {"enabled": False},  # messages are too small to benefit
            "link": {
                **_tls(connection.credentials),
                "rx": {"max_message_size": MAX_MESSAGE},  # limits the memory that a stranger can occupy
                "tx": {
                    # A sample that is kept keeps a buffer of this size (default 65535), which zenoh clears
                    # anew; a tick's batches are some hundred bytes.
                    "batch_size": 8192,
                    "lease": round(1000 * connection.lease),
                    "keep_alive": 4,
                    # A frozen subscriber holds up a blocking publisher this long, µs (default 5 s).
                    "queue": {"congestion_control": {"block": {"wait_before_close": 500_000}}},
                },
            },
        },
    }


def _tls(credentials: Credentials | None) -> Mapping[str, Any]:
    """Both ends show a certificate of the run's authority; that of the listening end has its host's name."""
    if credentials is None:
        return {}
    return {
        # Only TLS is allowed, also if an endpoint names another protocol.
        "protocols": ["tls"],
        "tls": {
            "root_ca_certificate": credentials.authority,
            "listen_certificate": credentials.certificate,
            "listen_private_key": credentials.key,
            "connect_certificate": credentials.certificate,
            "connect_private_key": credentials.key,
            "enable_mtls": True,
            "verify_name_on_connect": True,
            # A run does not outlive its keys.
            "close_link_on_expiration": True,
        },
    }


def _endpoints(connection: Connection) -> list[str]:
    """The endpoints to connect to, with the first marked as indispensable for a peer."""
    endpoints = list(map(str, connection.connect))
    if connection.mode == "peer" and endpoints:
        endpoints[0] += f"{';' if '#' in endpoints[0] else '#'}exit_on_failure=true"
    return endpoints
