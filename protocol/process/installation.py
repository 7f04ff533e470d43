"""The installation of this software: a checkout or a wheel, and the way to add missing libraries."""

from __future__ import annotations

import json
import sys
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from shlex import quote

from protocol.errors import UsageError

ROOT = Path(__file__).resolve().parents[2]


def is_checkout(root: Path = ROOT) -> bool:
    """Whether this software runs from its repository, rather than from an installed wheel."""
    return (root / "pyproject.toml").is_file() and (root / "Makefile").is_file()


def missing_library(what: str, library: str, extra: str) -> UsageError:
    """The error for `what` (such as "a picture") that needs a library of an extra."""
    return UsageError(f"{what} needs the library {library}, which is not installed: {how_to_install(extra)}")


def explained(error: ModuleNotFoundError) -> UsageError | None:
    """The error to show for a missing library of an extra; None if `error` is a fault of this software."""
    is_scipy = (error.name or "").partition(".")[0] == "scipy"
    return missing_library("this command", "scipy", "theory") if is_scipy else None


def how_to_install(extra: str, root: Path = ROOT) -> str:
    """The command that adds the libraries of an extra to the installation in use."""
    pip = f"{quote(sys.executable)} -m pip install"
    if is_checkout(root):
        return f"`make setup` in {root}, or {pip} --editable {quote(f'{root}[{extra}]')}"
    return f"{pip} {quote(f'disknav[{extra}]{_origin()}')}"


def _origin() -> str:
    """Source of the wheel for pip, unless it was an index."""
    try:
        recorded = distribution("disknav").read_text("direct_url.json")
    except PackageNotFoundError:
        return ""
    return "" if recorded is None else f" @ {json.loads(recorded)['url']}"
