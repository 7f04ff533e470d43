"""How the processes of a secured run connect: which endpoints, which certificate, which rules."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from deploy.security.access import access_control
from deploy.security.roster import ROUTER, Roster, read
from protocol.bus.connection import Connection
from protocol.bus.credentials import Credentials, credentials
from protocol.errors import CertificateError, UsageError
from protocol.installation import missing_library

DEFAULT_PORT = 7447


@dataclass(frozen=True)
class Membership:
    """The part that `directory`, made by `disknav keys new`, gives to each role of a run.

    None stands for a network without keys: plain endpoints and no rules.
    """

    directory: Path | None = None

    @property
    def default_router(self) -> str:
        """Where a router is looked for unless told otherwise."""
        return f"{self.protocol}/127.0.0.1:{DEFAULT_PORT}"

    @property
    def protocol(self) -> str:
        """What endpoints of this network begin with."""
        return "tcp" if self.directory is None else "tls"

    def roster(self) -> Roster | None:
        """Who takes part, if that is restricted."""
        return None if self.directory is None else read(self.directory)

    def run(self, asked: str | None) -> str | None:
        """The name of the run: as asked for, else the roster's, else None.

        Raises:
            CertificateError: the keys are for a run with another name.
        """
        roster = self.roster()
        if roster is None:
            return asked
        if asked not in (None, roster.run):
            raise CertificateError(
                f"the certificates in {self.directory} are for the run {roster.run}, not {asked}"
            )
        return roster.run

    def client(self, role: str, routers: Sequence[str], *, timeout: float = 20.0) -> Connection:
        """Connection of `role` to the first router of `routers` that answers.

        Raises:
            CertificateError: the files of this role are missing, exposed, or do not fit together.
            UsageError: an endpoint is not of this kind of network.
        """
        return Connection(
            connect=self._checked(routers), timeout=timeout, credentials=self._credentials(role)
        )

    def router(self, listen: Sequence[str] = (), connect: Sequence[str] = ()) -> Connection:
        """Connection of a router, with the rules that it enforces; raises as `client` does."""
        roster = self.roster()
        return Connection(
            "router",
            self._checked(connect),
            self._checked(listen),
            credentials=self._credentials(ROUTER),
            access=None if roster is None else access_control(roster),
        )

    def _credentials(self, role: str) -> Credentials | None:
        if self.directory is None:
            return None
        try:
            from deploy.security.inspection import inspect
        except ModuleNotFoundError as error:
            raise missing_library("a certificate", "cryptography", "secure") from error
        found = credentials(self.directory, role)
        inspect(found, role)
        return found

    def _checked(self, endpoints: Sequence[str]) -> tuple[str, ...]:
        for endpoint in endpoints:
            if endpoint.startswith("tls/") and self.directory is None:
                raise UsageError(f"{endpoint} is protected by certificates: give --secure DIR, or use tcp/")
            if self.directory is not None and not endpoint.startswith("tls/"):
                raise UsageError(f"{endpoint} is not protected by certificates: with --secure, use tls/")
        return tuple(endpoints)
