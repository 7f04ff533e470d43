"""Where a process finds what proves its role: three files of one directory.

The directory, which `disknav keys new` fills, has `ca.pem`, the authority that everybody of a run
trusts, and for each role `ROLE.pem`, its certificate, and `ROLE.key`, its private key. A host needs
no more of it than `ca.pem` and the pairs of the roles that run there.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from protocol.errors import CertificateError

AUTHORITY = "ca.pem"


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
    """What `role` shows to others, found in `directory`.

    Raises:
        CertificateError: a file is missing, or the private key is exposed: it may be read by its owner
            only, and by a group if it is root's, as orchestrators hand keys to processes.
    """
    paths = [directory.absolute() / name for name in (AUTHORITY, certificate_file(role), key_file(role))]
    for path in paths:
        if not path.is_file():
            raise CertificateError(
                f"{path} does not exist, so there is no certificate for {role}; "
                f"`disknav keys new` makes one for each role of a run"
            )
    status = paths[2].stat()
    if exposed := status.st_mode & (0o037 if status.st_uid == 0 else 0o077):
        raise CertificateError(
            f"{paths[2]} is a private key that others can reach (mode bits {exposed:03o}): "
            f"chmod 600 it, or better make new keys"
        )
    return Credentials(*map(str, paths))
