"""An OpenSSH server on the loopback, with keys and a configuration of its own."""

import os
import pwd
import shutil
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.deploy.processes.ports import free_ports
from tests.until import until

ROOT = Path(__file__).parents[4]
SEARCHED = os.pathsep.join([os.environ.get("PATH", ""), "/usr/sbin", "/usr/local/sbin"])
SSHD = shutil.which("sshd", path=SEARCHED)
_SEPARATION = Path("/run/sshd")  # an sshd that is root wants it
_READY = 10.0  # s


def unable() -> str | None:
    """Why there can be no server here; None if there can."""
    if SSHD is None:
        return "sshd (openssh-server) is not installed"
    if shutil.which("ssh") is None:
        return "ssh (openssh-client) is not installed"
    return None


needs_sshd = pytest.mark.skipif(unable() is not None, reason=unable() or "")


@dataclass(frozen=True)
class Server:
    """A server that listens; `options` make ssh reach it."""

    port: int
    pid: int
    options: tuple[str, ...]

    @property
    def user(self) -> str:
        return pwd.getpwuid(os.geteuid()).pw_name

    @property
    def command(self) -> str:
        """How a shell there calls this code."""
        return f"env PYTHONPATH={ROOT} {sys.executable} -m disknav"


@contextmanager
def ssh_server(folder: Path) -> Iterator[Server]:
    """Serve this user on 127.0.0.1, to clients with the key in `folder`."""
    assert SSHD is not None
    if os.geteuid() == 0:
        _SEPARATION.mkdir(mode=0o755, exist_ok=True)
    for name in ("host", "user"):
        subprocess.run(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", str(folder / name)], check=True)
    (port,) = free_ports(1)
    config = folder / "sshd_config"
    config.write_text(_config(folder, port))
    log = (folder / "sshd.log").open("w")
    process = subprocess.Popen([SSHD, "-D", "-e", "-f", str(config)], stderr=log)
    known = folder / "known_hosts"
    known.write_text(f"[127.0.0.1]:{port} {(folder / 'host.pub').read_text()}")
    options = (
        *("-F", "none", "-p", str(port), "-i", str(folder / "user")),
        *("-o", f"UserKnownHostsFile={known}", "-o", "IdentitiesOnly=yes"),
    )
    try:
        _await(port, process)
        yield Server(port, process.pid, options)
    finally:
        process.terminate()
        process.wait(10.0)
        log.close()


def _config(folder: Path, port: int) -> str:
    return f"""\
Port {port}
ListenAddress 127.0.0.1
HostKey {folder / "host"}
AuthorizedKeysFile {folder / "user.pub"}
PidFile none
StrictModes no
UsePAM no
PasswordAuthentication no
PermitRootLogin yes
MaxStartups 100
"""


def _await(port: int, process: subprocess.Popen[bytes]) -> None:
    def listens() -> bool:
        assert process.poll() is None, "sshd ended at once"
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", port)) == 0

    until(listens, _READY, "sshd does not listen")
