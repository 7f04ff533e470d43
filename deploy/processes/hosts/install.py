"""Puts this software on a host of a table: this checkout, into an environment of its own there."""

from __future__ import annotations

import io
import shlex
import subprocess
import tarfile
from pathlib import Path, PurePosixPath

from deploy.processes.hosts.ssh import ssh_command
from deploy.processes.hosts.table import Host
from protocol.errors import ProcessError, UsageError

_ROOT = Path(__file__).parents[3]
_SOURCES = ("disknav", "protocol", "agents", "world", "deploy")
_BUILD = ("pyproject.toml", "hatch_build.py", "compile.py", "Makefile", "README.md", "LICENSE")
_PATIENCE = 1800.0  # s; compiling takes minutes on a small computer


def install(host: Host) -> PurePosixPath:
    """Make the environment in which the table expects this software there; returns its folder.

    What it depends on comes from the package index that pip there uses.

    Raises:
        UsageError: this is no checkout, or the table does not say where to.
        ProcessError: something there failed; its own words are on standard error.
    """
    if not (_ROOT / "pyproject.toml").is_file():
        raise UsageError("what is copied is a checkout, and this is none: run this from one")
    command = PurePosixPath(host.command)
    if not command.is_absolute() or command.parts[-2:] != ("bin", "disknav"):
        raise UsageError(
            f"host {host.name}: its `command` is {host.command!r}; make it FOLDER/bin/disknav, "
            f"with the folder that this software is to have there, from the root on"
        )
    folder = command.parent.parent
    done = subprocess.run(
        ssh_command(host, _script(folder)), input=_archive(), timeout=_PATIENCE, stdout=2, check=False
    )
    if done.returncode:
        raise ProcessError(f"host {host.name}: nothing was installed (status {done.returncode}); see above")
    return folder


def _script(folder: PurePosixPath) -> str:
    """For the shell there: a fresh copy of the sources comes in, and goes when it is installed."""
    there, copy = shlex.quote(str(folder)), shlex.quote(f"{folder}.sources")
    steps = (
        f"rm -rf {copy}",
        f"mkdir -p {there} {copy}",
        f"tar -xzf - -C {copy}",
        f"python3 -m venv {there}",
        f"{there}/bin/python -m pip install --quiet --upgrade --force-reinstall --no-deps {copy}",
        f"{there}/bin/python -m pip install --quiet {copy}'[secure]'",
        f"rm -rf {copy}",
    )
    return " && ".join(steps)


def _archive() -> bytes:
    """The sources, without what can be made of them."""
    written = io.BytesIO()
    with tarfile.open(fileobj=written, mode="w:gz") as archive:
        for name in (*_SOURCES, *_BUILD):
            archive.add(_ROOT / name, name, filter=_kept)
    return written.getvalue()


def _kept(entry: tarfile.TarInfo) -> tarfile.TarInfo | None:
    made = entry.name.endswith((".so", ".pyc", "__pycache__"))
    entry.uid = entry.gid = 0
    entry.uname = entry.gname = ""
    return None if made else entry
