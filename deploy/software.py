"""The installed software and its machine: compiled modules, digest, and findings of `disknav setup doctor`.

Compiled modules (`make compile`, by mypyc, beside their sources) give the same results to the last bit,
several times faster. Without them the sources run.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import platform
import re
import resource
import shutil
import sys
from collections.abc import Iterator
from functools import cache
from importlib.machinery import EXTENSION_SUFFIXES
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path
from typing import Any, Literal, NamedTuple

from disknav import ownership
from protocol.errors import UsageError
from protocol.process.installation import ROOT, how_to_install, is_checkout

SOFTWARE = ("protocol", "agents", "world", "deploy")


def compiled(root: Path = ROOT) -> list[Path]:
    """Sources in place of which Python loads a compiled module."""
    return [
        source
        for package in SOFTWARE
        for source in sorted((root / package).rglob("*.py"))
        if source.with_suffix(EXTENSION_SUFFIXES[0]).exists()
    ]


def check_compiled(root: Path = ROOT) -> None:
    """Check that no compiled module is older than its source.
    Raises UsageError if one is, which names it and the remedy.
    """
    for source in compiled(root):
        twin = source.with_suffix(EXTENSION_SUFFIXES[0])
        if twin.stat().st_mtime < source.stat().st_mtime:
            name = source.relative_to(root)
            raise UsageError(
                f"{name} has changed since it was compiled: run `make compile`, or remove {twin}"
            )


_PACKAGES = ("disknav", "eclipse-zenoh", "numpy", "msgspec", "pyrvo", "daqp")
_CODE = ("protocol", "agents", "world", "deploy/library", "deploy/theory", "deploy/studies")


def provenance(seed: int, transport: str, jobs: int) -> dict[str, Any]:
    """Provenance of a study's results: versions (None if not installed), digest, seed and machine."""
    import psutil  # only here

    return {
        "versions": {"python": platform.python_version(), **{name: _version(name) for name in _PACKAGES}},
        "code_sha256": code_digest(),
        "seed": seed,
        "transport": transport,
        "jobs": jobs,
        "machine": {
            "system": f"{platform.system()} {platform.release()}",
            "processor": _processor(),
            "cores": os.cpu_count(),
            "memory_gb": round(psutil.virtual_memory().total / 2**30, 1),
        },
    }


@cache
def code_digest(folders: tuple[str, ...] = _CODE) -> str:
    """SHA-256 over all sources and scenarios in `folders`, with their paths; by default those that results
    depend on.
    """
    digest = hashlib.sha256()
    for folder in folders:
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in (".py", ".toml"):
                digest.update(str(path.relative_to(ROOT)).encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _processor() -> str:
    information = Path("/proc/cpuinfo")
    if information.exists():
        for line in information.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


Grade = Literal["good", "note", "bad"]
_EXTRA = re.compile(r"([\w.-]+).*;\s*extra\s*==\s*['\"](\w+)['\"]")
_COLLECTIONS = ("all", "demo", "test")  # extras made of others
_UNSYNCHRONISED = 5  # TIME_ERROR of <sys/timex.h>
_TIMEX = 512  # bytes, more than struct timex takes anywhere
_FILES = 1024  # descriptors, enough for fifty robots
_CHROMIUM = ("chromium", "chromium-browser", "google-chrome")


class Finding(NamedTuple):
    """One checked property of this machine."""

    what: str
    level: Grade  # good; note: only a feature is missing; bad: fleets do not work
    text: str
    remedy: str = ""  # what to do, if anything


def findings() -> Iterator[Finding]:
    """All findings that need no fleet."""
    yield _installation()
    yield _packages()
    yield _compiled()
    yield from _extras()
    yield _program("ssh", ("ssh",), "fleets over several hosts", "openssh-client")
    yield _program("Chromium", _CHROMIUM, "tests of the live page", "chromium")
    yield _time_source()
    yield _descriptors()


def _installation() -> Finding:
    number = _version("disknav") or "without metadata"
    kind = f"checkout {ROOT}" if is_checkout() else f"wheel in {ROOT}"
    python = f"Python {platform.python_version()} ({sys.executable}), {platform.system()}"
    text = f"disknav {number}, {kind}; {python}"
    if platform.system() == "Linux":
        return Finding("installation", "good", text)
    return Finding("installation", "note", text, "tested on Linux only; see docs/guides/install.md")


def _packages() -> Finding:
    shared = [f"`{package}` by {', '.join(others)}" for package, others in ownership.shared().items()]
    if not shared:
        return Finding("packages", "good", "no other project installs one of disknav's top-level packages")
    text = f"also installed here: {'; '.join(shared)}. The last installation has overwritten the other"
    return Finding("packages", "bad", text, "give disknav an environment of its own: python -m venv DIR")


def _compiled() -> Finding:
    count = len(compiled())
    if count:
        return Finding("compiled", "good", f"{count} modules are compiled")
    text = "no modules are compiled: a robot's step takes about five times as long"
    if shutil.which("cc") is None and shutil.which("gcc") is None:
        text += "; there is no C compiler"
    again = "`make compile`" if is_checkout() else "install disknav again"
    return Finding("compiled", "note", text, f"install a C compiler and Python's headers, then {again}")


def _extras() -> Iterator[Finding]:
    try:
        found = [_EXTRA.match(line) for line in requires("disknav") or ()]
    except PackageNotFoundError:
        return
    wanted: dict[str, list[str]] = {}
    for match in found:
        if match is not None and match[2] not in _COLLECTIONS:
            wanted.setdefault(match[2], []).append(match[1])
    for extra, libraries in wanted.items():
        missing = [library for library in libraries if _version(library) is None]
        if missing:
            text = f"{', '.join(missing)} not installed"
            yield Finding(f"extra {extra}", "note", text, how_to_install(extra))
        else:
            yield Finding(f"extra {extra}", "good", ", ".join(libraries))


def _program(what: str, names: tuple[str, ...], purpose: str, package: str) -> Finding:
    for name in names:
        if path := shutil.which(name):
            return Finding(what, "good", path)
    return Finding(what, "note", f"not found; only for {purpose}", f"apt-get install {package}, or the like")


def _time_source() -> Finding:
    """Whether the kernel's clock is synchronised: control does not need it, timestamps of hosts do."""
    needed = "needed for logs of several hosts, and for poses and odometry stamped by different hosts"
    try:
        state = ctypes.CDLL(None).adjtimex(ctypes.create_string_buffer(_TIMEX))
    except AttributeError:
        return Finding("time source", "note", f"unknown on this system; {needed}")
    if state == _UNSYNCHRONISED:
        return Finding(
            "time source", "note", f"the clock is not synchronised; {needed}", "install chrony or the like"
        )
    return Finding("time source", "good", "the clock is synchronised")


def _descriptors() -> Finding:
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    text = f"{soft} open files per process, {os.cpu_count()} cores"
    if soft < _FILES:
        most = "unlimited" if hard == resource.RLIM_INFINITY else hard
        return Finding("limits", "note", text, f"for more than a few dozen robots: ulimit -n {most}")
    return Finding("limits", "good", text)
