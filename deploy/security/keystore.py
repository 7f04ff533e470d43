"""The directory of keys: written once, as a whole, for its owner's eyes only."""

from __future__ import annotations

import datetime
import os
import shutil
from collections.abc import Sequence
from pathlib import Path
from tempfile import mkdtemp

from deploy.security.roster import ROSTER, ROUTER, Roster, encoded, router_role
from protocol.bus.connection import AUTHORITY, certificate_file, key_file
from protocol.errors import UsageError
from protocol.process.installation import missing_library

_LONGEST = 36_500.0  # days

try:
    from deploy.security.certificates import Authority
except ModuleNotFoundError as error:
    raise missing_library("a certificate", "cryptography", "secure") from error

LOOPBACK = ("localhost", "127.0.0.1", "::1")


def create(
    directory: Path, roster: Roster, *, hosts: Sequence[str] = (), days: float = 30.0, force: bool = False
) -> datetime.datetime:
    """Make an authority and a certificate for every role; returns until when they are valid.

    `hosts` are the names and addresses, besides those of the loopback, at which the router is reached where
    there is one for all; else the roster says it of each.
    The directory appears whole or not at all. `force` replaces one that is there: everything signed
    before is then worthless to the new authority.

    Raises:
        UsageError: the directory exists and `force` is not set, is not a directory of keys, `days` is not
            positive, or there is no library for certificates.
    """
    if not 0.0 < days <= _LONGEST:
        raise UsageError(f"{days:g} days: certificates are valid for some time, at most {_LONGEST:g} days")
    _check_replaceable(directory, force)
    directory.parent.mkdir(parents=True, exist_ok=True)
    fresh = Path(mkdtemp(prefix=f".{directory.name}-", dir=directory.parent))  # mode 0700
    try:
        end = _fill(fresh, roster, hosts, days)
        if directory.exists():
            shutil.rmtree(directory)
        fresh.rename(directory)
    except BaseException:
        shutil.rmtree(fresh, ignore_errors=True)
        raise
    return end


def _check_replaceable(directory: Path, force: bool) -> None:
    if not directory.exists():
        return
    if not directory.is_dir() or (any(directory.iterdir()) and not (directory / ROSTER).exists()):
        raise UsageError(f"{directory} exists and is no directory of keys: name another")
    if (directory / ROSTER).exists() and not force:
        raise UsageError(f"{directory} has keys already; --force replaces them, and they are worthless then")


def _fill(directory: Path, roster: Roster, hosts: Sequence[str], days: float) -> datetime.datetime:
    authority = Authority(roster.run, days)
    _write(directory / AUTHORITY, authority.certificate, 0o644)
    homes: dict[str, Sequence[str]] = {
        router_role(name): home.addresses for name, home in roster.homes.items()
    } or {ROUTER: hosts}
    names = {role: tuple(dict.fromkeys((*LOOPBACK, *reached))) for role, reached in homes.items()}
    for role in roster.roles:
        pair = authority.issue(role, hosts=names.get(role, ()))
        _write(directory / certificate_file(role), pair.certificate, 0o644)
        _write(directory / key_file(role), pair.key, 0o600)
    _write(directory / ROSTER, encoded(roster), 0o644)
    return authority.end


def _write(path: Path, content: bytes, mode: int) -> None:
    """Write a new file that never had more permissions than `mode`, whatever the umask."""
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode)
    with os.fdopen(descriptor, "wb") as file:
        os.fchmod(descriptor, mode)
        file.write(content)
