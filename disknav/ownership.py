"""Whether the top-level packages that this Python finds are disknav's own.

`agents`, `world`, `deploy` and `protocol` are names that others use, too: a file of the user's beside the
script, or another distribution in the same environment. What this module raises cannot be one of
`protocol.errors`: that package may be the stranger.
"""

from __future__ import annotations

import hashlib
import sys
from base64 import urlsafe_b64encode
from collections.abc import Iterator
from importlib.machinery import PathFinder
from importlib.metadata import PackageNotFoundError, distribution, packages_distributions
from pathlib import Path

PACKAGES = ("protocol", "agents", "world", "deploy")
HOME = Path(__file__).resolve().parents[1]
_APART = "give disknav an environment of its own: `python -m venv DIR`, then `DIR/bin/pip install` as before"


class ForeignPackageError(ImportError):
    """A top-level package that disknav needs belongs to another project; names it, and the cure."""


def check(home: Path = HOME) -> None:
    """Make sure that what Python finds under disknav's names is disknav's, as it was installed.

    Raises:
        ForeignPackageError: another package is found first, or has overwritten disknav's.
    """
    for package in PACKAGES:
        found = _found(package)
        if found is None:
            raise ForeignPackageError(
                f"`{package}` of disknav is missing from {home}: another package was installed over it and "
                "removed; pip install --force-reinstall --no-deps disknav"
            )
        if found != home / package:
            raise ForeignPackageError(
                f"`{package}` is {found}, which is not disknav's ({home / package}); "
                f"rename it, start from another folder, or {_APART}"
            )
    for package in _overwritten(home):
        others = ", ".join(shared().get(package, ())) or "something else"
        raise ForeignPackageError(f"`{package}` of disknav in {home} was overwritten by {others}; {_APART}")


def shared() -> dict[str, list[str]]:
    """Other distributions that install a package of one of these names, by package; reads all metadata."""
    owners = packages_distributions()
    return {
        package: others
        for package in PACKAGES
        if (others := sorted({name for name in owners.get(package, ()) if name != "disknav"}))
    }


def _found(package: str) -> Path | None:
    """The folder or file that `import` takes; None if there is none."""
    if package in sys.modules:
        origin = getattr(sys.modules[package], "__file__", None)
    else:
        spec = PathFinder.find_spec(package)
        origin = None if spec is None else spec.origin
    if origin is None:
        return None
    path = Path(origin).resolve()
    return path.parent if path.stem == "__init__" else path


def _overwritten(home: Path) -> Iterator[str]:
    """Packages whose `__init__.py` is not the one that was installed; a checkout has no record of them."""
    try:
        installed = distribution("disknav")
    except PackageNotFoundError:
        return
    if Path(str(installed.locate_file(""))).resolve() != home:
        return
    recorded = {str(file): file.hash for file in installed.files or ()}
    for package in PACKAGES:
        name = f"{package}/__init__.py"
        if (known := recorded.get(name)) is not None and known.value != _digest(home / name):
            yield package


def _digest(path: Path) -> str:
    """As a wheel records it."""
    return urlsafe_b64encode(hashlib.sha256(path.read_bytes()).digest()).rstrip(b"=").decode()
