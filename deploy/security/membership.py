"""Connections of a run's processes, with or without keys: endpoints, certificates and access rules."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path

from deploy.security.roster import MONITOR, OPERATOR, ROUTER, KeyRoster, access_control, read, router_role
from protocol.bus.connection import (
    AUTHORITY,
    DEFAULT_PORT,
    Connection,
    Credentials,
    Endpoint,
    credentials,
    key_file,
)
from protocol.errors import CertificateError, UsageError
from protocol.keys import checked_run


@dataclass(frozen=True)
class KeyRing:
    """The keys and rules in `directory`, made by `disknav setup keys`.

    None means a network without keys: plain endpoints and no rules.
    """

    directory: Path | None = None

    @property
    def protocol(self) -> str:
        """Protocol of this network's endpoints."""
        return "tcp" if self.directory is None else "tls"

    def roster(self) -> KeyRoster | None:
        """The roster; None without keys."""
        return None if self.directory is None else read(self.directory)

    def run(self, asked: str | None) -> str | None:
        """Name of the run: as given, else the roster's, else None.
        Raises CertificateError if the keys are for a run with another name.
        """
        roster = self.roster()
        if roster is None:
            return asked
        if asked not in (None, roster.run):
            raise CertificateError(
                f"the certificates in {self.directory} are for the run {roster.run}, not {asked}"
            )
        return roster.run

    def named_run(self, asked: str | None) -> str:
        """Name of the run; raises UsageError if there is none."""
        run = self.run(asked)
        if run is None:
            raise UsageError("name the run, as for the rest of the fleet, or give --secure DIR")
        return checked_run(run)

    @property
    def viewer(self) -> str:
        """Role of a live page: operator, which may give orders, if its key is in the directory."""
        if self.directory is None or (self.directory / key_file(OPERATOR)).exists():
            return OPERATOR
        return MONITOR

    def client(self, role: str, routers: Sequence[str | None], *, timeout: float = 20.0) -> Connection:
        """Connection of `role` to the first router of `routers` that answers; the default one for None.

        Raises CertificateError if the files of this role are missing, readable by others, or do not match;
        UsageError if an endpoint is invalid, or of the other kind of network.
        """
        found = tuple(map(self.endpoint, routers))
        return Connection(connect=found, timeout=timeout, credentials=self._credentials(role))

    def router(self, listen: Sequence[str] = (), connect: Sequence[str] = (), host: str = "") -> Connection:
        """Connection of a router, with the rules that it enforces; raises as `client`.

        `host` is its name in the roster; by default the host whose router key is in the directory.
        """
        roster = self.roster()
        connection = Connection(
            "router", tuple(map(self.endpoint, connect)), tuple(map(self.endpoint, listen))
        )
        if roster is None:
            return connection
        host = host or self._host(roster)
        proof = self._credentials(router_role(host) if roster.homes else ROUTER)
        return replace(connection, credentials=proof, access=access_control(roster, host))

    def _host(self, roster: KeyRoster) -> str:
        """Host whose router key is in the directory; empty with one router for all."""
        if self.directory is None or not roster.homes:
            return ""
        here = [host for host in roster.homes if (self.directory / key_file(router_role(host))).exists()]
        if len(here) != 1:
            raise UsageError(
                f"{self.directory} has the keys of {len(here)} routers: name the host, "
                f"one of {', '.join(roster.homes)}"
            )
        return here[0]

    def _credentials(self, role: str) -> Credentials | None:
        if self.directory is None:
            return None
        from deploy.security.keystore import inspect

        found = credentials(self.directory, role)
        inspect(found, role)
        return found

    def end(self) -> datetime | None:
        """End of the validity of all certificates and links; None without keys."""
        if self.directory is None:
            return None
        from deploy.security.keystore import end_of

        return end_of(str(self.directory / AUTHORITY))

    def endpoint(self, text: str | None) -> Endpoint:
        """An endpoint of this network, whose protocol may be left out; None: the default one of a router.
        Raises UsageError if it is invalid, or of the other kind of network.
        """
        if text is None:
            return Endpoint.at(self.protocol, "127.0.0.1", DEFAULT_PORT)
        endpoint = Endpoint(text, self.protocol)
        if endpoint.protocol == "tls" and self.directory is None:
            raise UsageError(f"{endpoint} is protected by certificates: give --secure DIR, or use tcp/")
        if self.directory is not None and endpoint.protocol != "tls":
            raise UsageError(f"{endpoint} is not protected by certificates: with --secure, use tls/")
        return endpoint
