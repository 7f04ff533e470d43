"""Modules as their sources say, whatever is compiled."""

import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

_ROOT = Path(__file__).resolve().parent.parent


def interpreted(*names: str) -> list[ModuleType]:
    """Load these modules anew from their sources, each seeing those before it; nobody else sees them."""
    before = {name: sys.modules.get(name) for name in names}
    loaded = []
    try:
        for name in names:
            spec = spec_from_file_location(name, _ROOT / f"{name.replace('.', '/')}.py")
            assert spec is not None
            assert spec.loader is not None
            sys.modules[name] = module_from_spec(spec)
            spec.loader.exec_module(sys.modules[name])
            loaded.append(sys.modules[name])
    finally:
        for name, module in before.items():
            sys.modules.pop(name, None)
            if module is not None:
                sys.modules[name] = module
    return loaded
