"""The search's sources with one detail turned."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from types import ModuleType

import deploy.theory.certify

_SOURCES = ("boxes", "contractors", "curvature", "search")


def mutant(folder: Path, name: str, file: str, old: str, new: str) -> ModuleType:
    """The module `search` of a copy of the search in which `old` reads `new`; `old` occurs once."""
    package = folder / name
    package.mkdir()
    found = 0
    for each in _SOURCES:
        source = Path(deploy.theory.certify.__file__).with_name(f"{each}.py")
        text = source.read_text()
        for other in _SOURCES:
            text = text.replace(f"deploy.theory.certify.{other} ", f"{name}.{other} ")
        if source.name == file:
            found = text.count(old)
            text = text.replace(old, new)
        (package / source.name).write_text(text)
    assert found == 1, f"{old!r} occurs {found} times in {file}"
    sys.path.insert(0, str(folder))
    try:
        return importlib.import_module(f"{name}.search")
    finally:
        sys.path.remove(str(folder))
