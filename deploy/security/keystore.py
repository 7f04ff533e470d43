"""The directory of keys of a run: written as a whole, readable by its owner only, checked before use."""

from __future__ import annotations

import datetime
import re
from collections.abc import Sequence
from inspect import signature
from ipaddress import ip_address
from pathlib import Path

from deploy.output import whole_folder
from deploy.security.roster import ROSTER, ROUTER, KeyRoster, encoded, router_role
from protocol.bus.connection import AUTHORITY, Credentials, certificate_file, key_file
from protocol.errors import CertificateError, UsageError
from protocol.process.installation import missing_library

try:
    from cryptography import x509
    from cryptography.exceptions import InvalidSignature
    from cryptography.hazmat.primitives import hashes, serialization
    from cryptography.hazmat.primitives.asymmetric import ec
    from cryptography.hazmat.primitives.serialization import load_pem_private_key
    from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID
except ModuleNotFoundError as error:
    raise missing_library("a certificate", "cryptography", "secure") from error

_SKEW = datetime.timedelta(minutes=10)  # tolerated lag of a host's clock


class Authority:
    """Signs the certificates of one run, valid for `days` from now, as is its own `certificate` (PEM).

    Its private key is never written, so no member can be added later.
    """

    def __init__(self, run: str, days: float) -> None:
        self._run = run
        self._begin = datetime.datetime.now(datetime.UTC).replace(microsecond=0)
        self.end = self._begin + datetime.timedelta(days=days)
        self._key = ec.generate_private_key(ec.SECP256R1())
        self._name = _name(run, "authority")
        usage = _usage("key_cert_sign", "crl_sign")
        self.certificate = (
            self._builder(self._name, self._key)
            .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
            .add_extension(usage, critical=True)
            .sign(self._key, hashes.SHA256())
            .public_bytes(serialization.Encoding.PEM)
        )

    def issue(self, role: str, hosts: Sequence[str]) -> tuple[bytes, bytes]:
        """A certificate with common name `role`, and its private key, PEM.

        Only a certificate with `hosts` (names or addresses) is valid for a listener, so no robot can pose as
        a router.
        """
        key = ec.generate_private_key(ec.SECP256R1())
        purposes = [ExtendedKeyUsageOID.CLIENT_AUTH]
        if hosts:
            purposes.append(ExtendedKeyUsageOID.SERVER_AUTH)
        names = [*map(_host, hosts)] or [x509.DNSName(role)]
        certificate = (
            self._builder(_name(self._run, role), key)
            .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
            .add_extension(_usage("digital_signature"), critical=True)
            .add_extension(x509.ExtendedKeyUsage(purposes), critical=False)
            .add_extension(x509.SubjectAlternativeName(names), critical=False)
            .sign(self._key, hashes.SHA256())
        )
        return (
            certificate.public_bytes(serialization.Encoding.PEM),
            key.private_bytes(
                serialization.Encoding.PEM,
                serialization.PrivateFormat.PKCS8,
                serialization.NoEncryption(),
            ),
        )

    def _builder(self, subject: x509.Name, key: ec.EllipticCurvePrivateKey) -> x509.CertificateBuilder:
        return (
            x509.CertificateBuilder()
            .subject_name(subject)
            .issuer_name(self._name)
            .public_key(key.public_key())
            .serial_number(x509.random_serial_number())
            .not_valid_before(self._begin - _SKEW)
            .not_valid_after(self.end)
            .add_extension(x509.SubjectKeyIdentifier.from_public_key(key.public_key()), critical=False)
            .add_extension(
                x509.AuthorityKeyIdentifier.from_issuer_public_key(self._key.public_key()), critical=False
            )
        )


def _name(run: str, role: str) -> x509.Name:
    return x509.Name(
        [
            x509.NameAttribute(NameOID.ORGANIZATION_NAME, f"disknav {run}"[:64]),
            x509.NameAttribute(NameOID.COMMON_NAME, role),
        ]
    )


def _host(host: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ip_address(host))
    except ValueError:
        if not re.fullmatch(r"[\w.-]+", host, re.ASCII):
            raise UsageError(f"{host!r} is no host: give its name, in ASCII, or its address") from None
        return x509.DNSName(host)


def _usage(*granted: str) -> x509.KeyUsage:
    return x509.KeyUsage(**{name: name in granted for name in signature(x509.KeyUsage).parameters})


_LONGEST = 36_500.0  # days

LOOPBACK = ("localhost", "127.0.0.1", "::1")


def create(
    directory: Path, roster: KeyRoster, *, hosts: Sequence[str] = (), days: float = 30.0, force: bool = False
) -> datetime.datetime:
    """Make an authority and a certificate for every role; returns the end of their validity.

    The directory appears whole or not at all.

    Args:
        hosts: names and addresses of the router besides the loopback; with several routers the roster has
            them.
        force: replace an existing directory; its certificates are not valid with the new authority.

    Raises:
        UsageError: the directory exists and `force` is not set, or is not a directory of keys; or `days` is
            not positive.
    """
    if not 0.0 < days <= _LONGEST:
        raise UsageError(f"{days:g} days of validity: must be above 0 and at most {_LONGEST:g}")
    _check_replaceable(directory, force)
    with whole_folder(directory) as fresh:
        return _fill(fresh, roster, hosts, days)


def _check_replaceable(directory: Path, force: bool) -> None:
    if not directory.exists():
        return
    names = {path.name for path in directory.iterdir()} if directory.is_dir() else {directory.name}
    others = [name for name in names if name != ROSTER and not name.endswith((".pem", ".key"))]
    if others or (names and ROSTER not in names):
        raise UsageError(f"{directory} exists, but is not a directory of keys alone: name another")
    if names and not force:
        raise UsageError(f"{directory} has keys already: --force replaces them and makes them invalid")


def _fill(directory: Path, roster: KeyRoster, hosts: Sequence[str], days: float) -> datetime.datetime:
    authority = Authority(roster.run, days)
    _write(directory / AUTHORITY, authority.certificate, 0o644)
    homes: dict[str, Sequence[str]] = {
        router_role(name): home.addresses for name, home in roster.homes.items()
    } or {ROUTER: hosts}
    names = {role: tuple(dict.fromkeys((*LOOPBACK, *reached))) for role, reached in homes.items()}
    for role in roster.roles:
        certificate, key = authority.issue(role, names.get(role, ()))
        _write(directory / certificate_file(role), certificate, 0o644)
        _write(directory / key_file(role), key, 0o600)
    _write(directory / ROSTER, encoded(roster), 0o644)
    return authority.end


def _write(path: Path, content: bytes, mode: int) -> None:
    path.touch(mode, exist_ok=False)
    path.chmod(mode)  # whatever the umask
    path.write_bytes(content)


def inspect(credentials: Credentials, role: str) -> None:
    """Check that the certificate is for `role`, by this authority, valid now, and belongs to the key.
    Raises CertificateError that names the failed check.
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
            f"it belongs to another run, or is older than the last `disknav setup keys`"
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
    """End of validity of an authority and its certificates; raises CertificateError if unreadable."""
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
