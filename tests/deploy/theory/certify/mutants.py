"""The search's sources with one thing turned, run by the interpreter."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from types import ModuleType

import deploy.theory.certify.boxes

_IDENTITY = "def compiled(function):\n    return function\n"


def mutant(folder: Path, name: str, file: str, old: str, new: str) -> ModuleType:
    """The module `search` of a copy of deploy.theory.certify.boxes in which `old` reads `new`; `old` occurs
    once."""
    package = folder / name
    package.mkdir()
    found = 0
    for source in Path(deploy.theory.certify.boxes.__file__).parent.glob("*.py"):
        text = source.read_text().replace("deploy.theory.certify.boxes", name)
        if source.name == file:
            found = text.count(old)
            text = text.replace(old, new)
        (package / source.name).write_text(_IDENTITY if source.name == "kernel.py" else text)
    assert found == 1, f"{old!r} occurs {found} times in {file}"
    sys.path.insert(0, str(folder))
    try:
        return importlib.import_module(f"{name}.search")
    finally:
        sys.path.remove(str(folder))
