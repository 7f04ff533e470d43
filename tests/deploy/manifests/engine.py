"""A container engine for tests: podman, with a store of this checkout.

`python -m tests.deploy.manifests.engine` (`make engines`) fills it, in some minutes: a Debian root file
system from the package sources of this machine, and on it this software, by the Containerfile. What starts
containers is skipped where they are not there, and says so: it is untested then.
"""

import os
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

from deploy.software import SOFTWARE, code_digest

ROOT = Path(__file__).parents[3]
STORE = (ROOT / "build" / "engines").resolve()
IMAGE = "localhost/disknav"
_DEBIAN = "localhost/disknav-debian"
_CODE = "disknav.code"  # of the image: a digest of the sources that are in it
_CERTIFICATES = Path("/etc/ssl/certs")
_PACKAGES = "python3,python3-venv,python3-dev,gcc,libc6-dev,make,systemd,systemd-sysv,dbus"
_TOOLS = ("podman", "catatonit")


@cache
def unable() -> str:
    """Why no container can be started here; empty if some can."""
    for tool in _TOOLS:
        if shutil.which(tool) is None:
            return f"{tool} is not installed: untested here"
    if not STORE.exists() or podman("image", "exists", IMAGE, check=False).returncode:
        return "there is no image of this software: `make engines` makes one; untested here"
    label = podman("image", "inspect", "--format", f'{{{{index .Labels "{_CODE}"}}}}', IMAGE)
    if label.stdout.strip() != code_digest(SOFTWARE):
        return "the image is of other code: `make engines` makes it anew; untested here"
    return ""


def command(*arguments: str | Path) -> list[str]:
    """podman on the store of this checkout."""
    storage = ["--root", f"{STORE}/root", "--runroot", f"{STORE}/run", "--storage-driver", "overlay"]
    return ["podman", *storage, *map(str, arguments)]


def podman(
    *arguments: str | Path, check: bool = True, timeout: float = 60.0
) -> subprocess.CompletedProcess[str]:
    done = subprocess.run(
        command(*arguments), capture_output=True, text=True, timeout=timeout, check=False, env=environment()
    )
    assert done.returncode == 0 or not check, f"podman {arguments[0]}: {done.stdout}{done.stderr}"
    return done


def environment() -> dict[str, str]:
    """With a configuration that also starts containers where this user's own limits are low."""
    STORE.mkdir(parents=True, exist_ok=True)
    config = STORE / "containers.conf"
    runtime = '[engine]\nruntime = "runc"\n' if shutil.which("runc") else ""
    config.write_text(f'[containers]\ndefault_ulimits = ["nofile=1024:1024", "nproc=1024:1024"]\n{runtime}')
    return {**os.environ, "CONTAINERS_CONF": str(config)}


needs_engine = pytest.mark.skipif(bool(unable()), reason=unable())


def _fill() -> None:
    archive = STORE / "debian.tar"
    if podman("image", "exists", _DEBIAN, check=False).returncode:
        making = ["mmdebstrap", "--variant=minbase", f"--include={_PACKAGES}", "bookworm", str(archive)]
        subprocess.run(making, check=True)
        subprocess.run(command("import", archive, _DEBIAN), check=True, env=environment())
        archive.unlink()
    bases = [word for name in ("BUILD", "BASE") for word in ("--build-arg", f"{name}={_DEBIAN}")]
    trust = ["--volume", f"{_CERTIFICATES}:{_CERTIFICATES}:ro", "--network=host"]
    for name in ("PIP_CERT", "PIP_INDEX_URL"):
        trust += ["--env", f"{name}={os.environ[name]}"] if name in os.environ else []
    label = ["--label", f"{_CODE}={code_digest(SOFTWARE)}"]
    build = ["build", *bases, *trust, *label, "-t", IMAGE, "-f", "Containerfile", "."]
    subprocess.run(command(*build), check=True, env=environment(), cwd=ROOT)


if __name__ == "__main__":
    sys.exit(_fill())
