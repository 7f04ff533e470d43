"""Whether a role's files fit together, found out before anybody is asked over the network."""

from __future__ import annotations

import datetime
from pathlib import Path

from cryptography import x509
from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives.serialization import load_pem_private_key
from cryptography.x509.oid import NameOID

from protocol.bus.connection import Credentials
from protocol.errors import CertificateError


def inspect(credentials: Credentials, role: str) -> None:
    """Check that the certificate is for `role`, by this authority, valid now, and belongs to the key.

    Raises:
        CertificateError: it is not; says which.
    """
    authority = _read(credentials.authority)
    certificate = _read(credentials.certificate)
    names = [name.value for name in certificate.subject.get_attributes_for_oid(NameOID.COMMON_NAME)]
    if names != [role]:
        raise CertificateError(f"{credentials.certificate} is the certificate of {names}, not of {role}")
    try:
        certificate.verify_directly_issued_by(authority)
    except (InvalidSignature, ValueError, TypeError) as error:
        raise CertificateError(
            f"{credentials.certificate} was not signed by the authority {credentials.authority}: "
            f"it is of another run, or older than the last `disknav setup keys`"
        ) from error
    _check_validity(certificate, credentials.certificate)
    _check_key(certificate, credentials)


def _check_validity(certificate: x509.Certificate, path: str) -> None:
    now = datetime.datetime.now(datetime.UTC)
    begin, end = certificate.not_valid_before_utc, certificate.not_valid_after_utc
    if not begin <= now <= end:
        raise CertificateError(
            f"the certificate {path} is valid from {begin:%Y-%m-%d %H:%M} to {end:%Y-%m-%d %H:%M} UTC, "
            f"and this host's clock says {now:%Y-%m-%d %H:%M}; `disknav setup keys --force` makes new ones"
        )


def end_of(authority: str) -> datetime.datetime:
    """When the certificates of a run end: all of them when that of its authority does.

    Raises:
        CertificateError: it cannot be read.
    """
    return _read(authority).not_valid_after_utc


def _check_key(certificate: x509.Certificate, credentials: Credentials) -> None:
    try:
        key = load_pem_private_key(Path(credentials.key).read_bytes(), password=None)
    except (OSError, ValueError, TypeError) as error:
        raise CertificateError(f"{credentials.key} cannot be read as a private key: {error}") from error
    if key.public_key() != certificate.public_key():
        raise CertificateError(
            f"{credentials.key} is not the private key of the certificate {credentials.certificate}"
        )


def _read(path: str) -> x509.Certificate:
    try:
        return x509.load_pem_x509_certificate(Path(path).read_bytes())
    except (OSError, ValueError) as error:
        raise CertificateError(f"{path} cannot be read as a certificate: {error}") from error
