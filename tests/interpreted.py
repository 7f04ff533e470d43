"""Modules as their sources say, or as they would read with a few words changed, whatever is compiled."""

import sys
from collections.abc import Sequence
from functools import cache
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import spec_from_loader
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any, NamedTuple

from deploy.software.compiled import compiled

_ROOT = Path(__file__).resolve().parent.parent
_TWINS = frozenset(".".join(path.relative_to(_ROOT).with_suffix("").parts) for path in compiled())


class Edit(NamedTuple):
    """Words of one module's source, which must occur exactly once, and what they are replaced by."""

    module: str
    old: str
    new: str


def interpreted(*names: str, edits: Sequence[Edit] = ()) -> list[ModuleType]:
    """Load these modules from their sources, and whatever compiled ones they import, for the caller alone."""
    assert {edit.module for edit in edits} <= set(names)
    anew = _TWINS | set(names)
    before = {name: sys.modules.pop(name) for name in anew & set(sys.modules)}
    finder = _Sources(anew, edits)
    sys.meta_path.insert(0, finder)
    try:
        return [import_module(name) for name in names]
    finally:
        sys.meta_path.remove(finder)
        for name in anew:
            sys.modules.pop(name, None)
        sys.modules.update(before)
        for name, module in before.items():  # an import leaves the module in its package, too
            package, _, last = name.rpartition(".")
            setattr(sys.modules[package], last, module)


class _Sources(MetaPathFinder, Loader):
    """Finds and executes the sources of some modules, edited."""

    def __init__(self, names: frozenset[str], edits: Sequence[Edit]) -> None:
        self._names, self._edits = names, edits

    def find_spec(self, fullname: str, path: Any, target: Any = None) -> ModuleSpec | None:
        if fullname not in self._names:
            return None
        return spec_from_loader(fullname, self, origin=str(_path(fullname)))

    def exec_module(self, module: ModuleType) -> None:
        module.__file__ = str(_path(module.__name__))
        edits = tuple(edit for edit in self._edits if edit.module == module.__name__)
        exec(_compiled(module.__name__, edits), vars(module))


def _path(name: str) -> Path:
    return _ROOT / f"{name.replace('.', '/')}.py"


@cache
def _compiled(name: str, edits: tuple[Edit, ...]) -> CodeType:
    source = _path(name).read_text()
    for edit in edits:
        assert source.count(edit.old) == 1, f"{name} does not say {edit.old!r} once: change the edit with it"
        source = source.replace(edit.old, edit.new)
    return compile(source, _path(name), "exec")
