"""A secured router against strangers, and the errors that a wrong certificate causes."""

import shutil
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from deploy.processes import table
from deploy.processes.router import main
from deploy.processes.supervisor import Supervisor
from deploy.security.keystore import create
from deploy.security.membership import KeyRing
from deploy.security.roster import KeyRoster
from protocol.bus.connection import Connection, Credentials, credentials
from protocol.bus.zenoh import ZenohBus
from protocol.errors import CertificateError

pytestmark = [pytest.mark.usefixtures("interruptible"), pytest.mark.process, pytest.mark.timeout(90)]

ROSTER = KeyRoster("guarded", (1, 2, 3, 4, 5, 6))


@pytest.fixture(scope="module")
def endpoint(keys: Path) -> Iterator[str]:
    with Supervisor() as supervisor:
        supervisor.start([table.router(KeyRing(keys).router())])
        yield supervisor.report("router", 20.0)


def member(keys: Path, role: str, endpoint: str) -> ZenohBus:
    return ZenohBus(KeyRing(keys).client(role, (endpoint,), timeout=5.0))


def stranger(endpoint: str, proof: Credentials | None, timeout: float = 5.0) -> ZenohBus:
    """A session that ignores the rules."""
    return ZenohBus(Connection(connect=(endpoint,), timeout=timeout, credentials=proof))


def test_certificates_of_other_authorities_and_older_runs(keys: Path, endpoint: str, tmp_path: Path) -> None:
    create(tmp_path / "before", ROSTER)  # same run, same roles, other keys
    with pytest.raises(CertificateError, match=r"certificate of the router .* is not accepted here"):
        member(tmp_path / "before", "robot-1", endpoint)
    # An attacker may well have the public half of the right authority.
    shutil.copy(keys / "ca.pem", tmp_path / "before" / "ca.pem")
    with pytest.raises(CertificateError, match=r"refuses the certificate .*not signed by the authority"):
        stranger(endpoint, credentials(tmp_path / "before", "robot-1"))


def test_without_a_certificate_no_client_gets_in_and_each_is_told_why(endpoint: str) -> None:
    with pytest.raises(CertificateError, match=r"demands certificates.*--secure"):
        stranger(endpoint.replace("tls/", "tcp/"), None)
    with pytest.raises(CertificateError, match=r"demands certificates.*--secure"):
        stranger(endpoint, None)


def test_an_expired_certificate_says_so(tmp_path: Path) -> None:
    create(tmp_path / "keys", ROSTER, days=1e-9)
    proof = credentials(tmp_path / "keys", "robot-1")
    listener = Connection("router", credentials=credentials(tmp_path / "keys", "router"))
    failures: list[str] = []

    def ready(endpoint: str) -> None:
        deadline = time.monotonic() + 20.0
        while not failures and time.monotonic() < deadline:
            try:
                stranger(endpoint, proof, 0.5).close()
            except CertificateError as error:
                failures.append(str(error))
        signal.raise_signal(signal.SIGINT)

    assert main(listener, ready=ready) == 0
    assert "expired" in failures[0]


def test_a_robots_key_cannot_pose_as_the_router(keys: Path) -> None:
    impostor = Connection("router", credentials=credentials(keys, "robot-1"))

    def ready(endpoint: str) -> None:
        with pytest.raises(CertificateError, match="unsuitable certificate purpose"):
            member(keys, "robot-2", endpoint)
        signal.raise_signal(signal.SIGINT)

    assert main(impostor, ready=ready) == 0
