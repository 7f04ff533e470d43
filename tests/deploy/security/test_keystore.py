"""The directory of keys: its permissions and contents, and that it is never overwritten by accident."""

import os
import shutil
from pathlib import Path

import pytest
from cryptography import x509
from cryptography.x509.oid import ExtendedKeyUsageOID

from deploy.security.keystore import Authority, create, inspect
from deploy.security.membership import KeyRing
from deploy.security.roster import KeyRoster, read
from protocol.bus.connection import credentials
from protocol.errors import CertificateError, UsageError

ROSTER = KeyRoster("demo", (1, 2, 7))


@pytest.fixture
def keys(tmp_path: Path) -> Path:
    create(tmp_path / "keys", ROSTER, hosts=["10.0.0.1", "base.example"])
    return tmp_path / "keys"


def certificate(path: Path) -> x509.Certificate:
    return x509.load_pem_x509_certificate(path.read_bytes())


@pytest.mark.parametrize("umask", [0o000, 0o077])
def test_private_keys_are_their_owners_alone(tmp_path: Path, umask: int) -> None:
    before = os.umask(umask)
    try:
        create(tmp_path / "keys", ROSTER)
    finally:
        os.umask(before)
    assert (tmp_path / "keys").stat().st_mode & 0o777 == 0o700
    modes = {path.name: path.stat().st_mode & 0o777 for path in (tmp_path / "keys").iterdir()}
    assert {mode for name, mode in modes.items() if name.endswith(".key")} == {0o600}
    assert {mode for name, mode in modes.items() if not name.endswith(".key")} == {0o644}


def test_no_file_keeps_the_authoritys_private_key(keys: Path) -> None:
    secrets = {path.stem for path in keys.iterdir() if b"PRIVATE KEY" in path.read_bytes()}
    assert secrets == set(ROSTER.roles)


def test_a_certificate_for_each_role_and_no_other(keys: Path) -> None:
    assert read(keys) == ROSTER
    assert {path.stem for path in keys.glob("*.pem")} == {"ca", *ROSTER.roles}
    for role in ROSTER.roles:
        inspect(credentials(keys, role), role)


def test_only_the_router_may_listen_and_only_at_its_hosts(keys: Path) -> None:
    for role in ROSTER.roles:
        usage = certificate(keys / f"{role}.pem").extensions.get_extension_for_class(x509.ExtendedKeyUsage)
        assert (ExtendedKeyUsageOID.SERVER_AUTH in usage.value) == (role == "router")
    names = certificate(keys / "router.pem").extensions.get_extension_for_class(x509.SubjectAlternativeName)
    addresses = {str(address) for address in names.value.get_values_for_type(x509.IPAddress)}
    assert addresses == {"127.0.0.1", "::1", "10.0.0.1"}
    assert names.value.get_values_for_type(x509.DNSName) == ["localhost", "base.example"]


def test_keys_are_replaced_only_by_force_and_then_all_of_them(keys: Path) -> None:
    before = {path.name: path.read_bytes() for path in keys.iterdir()}
    with pytest.raises(UsageError, match="--force"):
        create(keys, ROSTER)
    assert {path.name: path.read_bytes() for path in keys.iterdir()} == before
    create(keys, KeyRoster("demo", (1,)), force=True)
    assert not (keys / "robot-7.key").exists()
    assert (keys / "ca.pem").read_bytes() != before["ca.pem"]


def test_a_directory_with_something_else_is_left_alone_even_by_force(keys: Path, tmp_path: Path) -> None:
    for folder in keys, tmp_path:
        (folder / "thesis.tex").write_text("years of work")
        with pytest.raises(UsageError, match="not a directory of keys alone"):
            create(folder, ROSTER, force=True)
        assert (folder / "thesis.tex").read_text() == "years of work"


def test_a_failure_leaves_nothing_behind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise OSError("no space left on device")

    monkeypatch.setattr(Authority, "issue", fail)
    with pytest.raises(UsageError, match="no space"):
        create(tmp_path / "keys", ROSTER)
    assert list(tmp_path.iterdir()) == []


def test_a_key_that_is_exposed_and_what_does_not_fit_together_are_refused(keys: Path, tmp_path: Path) -> None:
    other = tmp_path / "other"
    create(other, ROSTER)
    membership, router = KeyRing(keys), ["tls/127.0.0.1:7447"]

    def swap(source: Path, target: str) -> None:
        shutil.copy(source, keys / target)

    with pytest.raises(CertificateError, match=r"robot-9\.pem does not exist"):
        membership.client("robot-9", router)
    swap(keys / "robot-2.pem", "robot-1.pem")
    with pytest.raises(CertificateError, match=r"certificate of \['robot-2'\], not of robot-1"):
        membership.client("robot-1", router)
    swap(other / "robot-1.pem", "robot-1.pem")
    with pytest.raises(CertificateError, match="not signed by the authority"):
        membership.client("robot-1", router)
    swap(other / "world.key", "world.key")
    with pytest.raises(CertificateError, match="not the private key of the certificate"):
        membership.client("world", router)
    (keys / "robot-7.key").chmod(0o644)
    with pytest.raises(CertificateError, match="others can reach"):
        membership.client("robot-7", router)


def test_expired_certificates_are_named(tmp_path: Path) -> None:
    create(tmp_path / "keys", ROSTER, days=1e-9)
    with pytest.raises(CertificateError, match=r"valid from .* to .* UTC"):
        KeyRing(tmp_path / "keys").client("robot-1", ["tls/127.0.0.1:7447"])
