"""Modules as their sources say, or as they would read with a few words changed, whatever is compiled."""

import sys
from collections.abc import Sequence
from functools import cache
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import CodeType, ModuleType
from typing import NamedTuple

_ROOT = Path(__file__).resolve().parent.parent


class Edit(NamedTuple):
    """Words of one module's source, which must occur exactly once, and what they are replaced by."""

    module: str
    old: str
    new: str


def interpreted(*names: str, edits: Sequence[Edit] = ()) -> list[ModuleType]:
    """Load these modules anew from their sources, each seeing those before it; nobody else sees them."""
    assert {edit.module for edit in edits} <= set(names)
    before = {name: sys.modules.get(name) for name in names}
    loaded = []
    try:
        for name in names:
            spec = spec_from_file_location(name, _path(name))
            assert spec is not None
            sys.modules[name] = module_from_spec(spec)
            code = _compiled(name, tuple(edit for edit in edits if edit.module == name))
            exec(code, vars(sys.modules[name]))
            loaded.append(sys.modules[name])
    finally:
        for name, module in before.items():
            sys.modules.pop(name, None)
            if module is not None:
                sys.modules[name] = module
    return loaded


def _path(name: str) -> Path:
    return _ROOT / f"{name.replace('.', '/')}.py"


@cache
def _compiled(name: str, edits: tuple[Edit, ...]) -> CodeType:
    source = _path(name).read_text()
    for edit in edits:
        assert source.count(edit.old) == 1, f"{name} does not say {edit.old!r} once: change the edit with it"
        source = source.replace(edit.old, edit.new)
    return compile(source, _path(name), "exec")
