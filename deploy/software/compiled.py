"""The inner loops, compiled: `make compile` lets mypyc make C of modules of robots and world, beside them.

What is compiled does the same to the last bit, several times faster; where nothing is, the sources run.
"""

from __future__ import annotations

from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path

from protocol.errors import UsageError
from protocol.process.installation import ROOT

_PACKAGES = ("protocol", "agents", "world", "deploy")


def compiled(root: Path = ROOT) -> list[Path]:
    """Sources that have a compiled twin which this Python loads instead."""
    return [
        source
        for package in _PACKAGES
        for source in sorted((root / package).rglob("*.py"))
        if source.with_suffix(EXTENSION_SUFFIXES[0]).exists()
    ]


def check(root: Path = ROOT) -> None:
    """Find out whether what would run is what the sources say.

    Raises:
        UsageError: a source is newer than its compiled twin; names it and says what to do.
    """
    for source in compiled(root):
        twin = source.with_suffix(EXTENSION_SUFFIXES[0])
        if twin.stat().st_mtime < source.stat().st_mtime:
            name = source.relative_to(root)
            raise UsageError(
                f"{name} has changed since it was compiled: run `make compile`, or remove {twin}"
            )
