"""Modules as their sources say, or as they would read with a few words changed, whatever is compiled."""

import builtins
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import find_spec, spec_from_loader
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any, NamedTuple

from deploy.software import compiled

_ROOT = Path(__file__).resolve().parent.parent
_NAMES = (".".join(path.relative_to(_ROOT).with_suffix("").parts) for path in compiled())
_TWINS = frozenset(name for name in _NAMES if not str(find_spec(name).origin).endswith(".py"))  # type: ignore[union-attr]  # found


class Edit(NamedTuple):
    """Words of one module's source, which must occur exactly once, and what they are replaced by."""

    module: str
    old: str
    new: str


class Mutant(NamedTuple):
    """The product without one rule.

    Attributes:
        rule: its short name.
        says: the rule.
        edits: what reads otherwise without it.
        model: whose random runs find a violation.
        first: the random run to begin with, where it takes many to come to one that shows the mutant.
    """

    rule: str
    says: str
    edits: tuple[Edit, ...]
    model: str
    first: int

    def hunt(self, violation_of: Callable[[int], str], runs: int) -> str:
        """The first violation in so many random runs; "" if they show none."""
        return next(filter(None, map(violation_of, range(self.first, self.first + runs))), "")


def without(rule: str, says: str, *edits: Edit, model: str = "skirmish", first: int = 0) -> Mutant:
    """The product without the rule that these words state."""
    return Mutant(rule, says, edits, model, first)


def interpreted(*names: str, edits: Sequence[Edit] = ()) -> list[ModuleType]:
    """Load these modules from their sources, and whatever compiled ones they import, for the caller alone."""
    assert {edit.module for edit in edits} <= set(names)
    sources = _Sources(_TWINS | set(names), edits)
    with sources.in_place():
        return [import_module(name) for name in names]


class _Sources(MetaPathFinder, Loader):
    """Finds and executes the sources of some modules, edited, and keeps what came of it apart.

    What these modules import later, within a function, comes from the sources, too.
    """

    def __init__(self, names: frozenset[str], edits: Sequence[Edit]) -> None:
        self._names, self._edits = names, edits
        self._loaded: dict[str, ModuleType] = {}
        self._inside = False

    @contextmanager
    def in_place(self) -> Iterator[None]:
        """Inside, imports find these modules in place of the others of their names."""
        before = {name: sys.modules.pop(name) for name in self._names & set(sys.modules)}
        sys.modules.update(self._loaded)
        sys.meta_path.insert(0, self)
        self._inside = True
        try:
            yield
        finally:
            self._inside = False
            sys.meta_path.remove(self)
            self._loaded = {name: sys.modules.pop(name) for name in self._names & set(sys.modules)}
            sys.modules.update(before)
            for name, module in before.items():  # an import leaves the module in its package, too
                package, _, last = name.rpartition(".")
                setattr(sys.modules[package], last, module)

    def find_spec(self, fullname: str, path: Any, target: Any = None) -> ModuleSpec | None:
        if fullname not in self._names:
            return None
        return spec_from_loader(fullname, self, origin=str(_path(fullname)))

    def exec_module(self, module: ModuleType) -> None:
        module.__file__ = str(_path(module.__name__))
        edits = tuple(edit for edit in self._edits if edit.module == module.__name__)
        vars(module)["__builtins__"] = {**vars(builtins), "__import__": self._import}
        exec(_compiled(module.__name__, edits), vars(module))

    def _import(self, *request: Any, **options: Any) -> Any:
        if self._inside:
            return builtins.__import__(*request, **options)
        with self.in_place():
            return builtins.__import__(*request, **options)


def _path(name: str) -> Path:
    return _ROOT / f"{name.replace('.', '/')}.py"


@cache
def _compiled(name: str, edits: tuple[Edit, ...]) -> CodeType:
    source = _path(name).read_text()
    for edit in edits:
        assert source.count(edit.old) == 1, f"{name} does not say {edit.old!r} once: change the edit with it"
        source = source.replace(edit.old, edit.new)
    return compile(source, _path(name), "exec")
