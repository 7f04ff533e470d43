"""Where the figures of a study come from: versions, seed, machine, and a digest of the code."""

from __future__ import annotations

import hashlib
import os
import platform
from collections.abc import Iterator
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import psutil

_PACKAGES = ("disknav", "eclipse-zenoh", "numpy", "msgspec", "pyrvo", "daqp")
_CODE = ("protocol", "agents", "world", "deploy/library", "deploy/theory", "deploy/studies")
SOFTWARE = ("protocol", "agents", "world", "deploy")  # all of it
_ROOT = Path(__file__).parents[2]


def provenance(seed: int, transport: str, jobs: int) -> dict[str, Any]:
    """In plain types; a package that is not installed has None for its version."""
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
    """SHA-256 over all sources in `folders` (if not given: what results depend on), with their paths."""
    digest = hashlib.sha256()
    for path in _sources(folders):
        digest.update(str(path.relative_to(_ROOT)).encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()


def _sources(folders: tuple[str, ...]) -> Iterator[Path]:
    for folder in folders:
        yield from sorted((_ROOT / folder).rglob("*.py"))


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
