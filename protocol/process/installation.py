"""Which installation of this software runs: a checkout or a wheel, and how to add to it what is missing."""

from __future__ import annotations

import json
import sys
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from shlex import quote

from protocol.errors import UsageError

ROOT = Path(__file__).resolve().parents[1]


def is_checkout(root: Path = ROOT) -> bool:
    """Whether this software runs from its repository, rather than from an installed wheel."""
    return (root / "pyproject.toml").is_file() and (root / "Makefile").is_file()


def missing_library(what: str, library: str, extra: str) -> UsageError:
    """What to tell who asks for `what` (such as "a picture") without the library for it."""
    return UsageError(f"{what} needs the library {library}, which is not installed: {how_to_install(extra)}")


def how_to_install(extra: str, root: Path = ROOT) -> str:
    """The command that adds the libraries of an extra to the installation in use."""
    pip = f"{quote(sys.executable)} -m pip install"
    if is_checkout(root):
        return f"`make setup` in {root}, or {pip} --editable {quote(f'{root}[{extra}]')}"
    return f"{pip} {quote(f'disknav[{extra}]{_origin()}')}"


def _origin() -> str:
    """Where pip got the wheel from, unless it was an index."""
    try:
        recorded = distribution("disknav").read_text("direct_url.json")
    except PackageNotFoundError:
        return ""
    return "" if recorded is None else f" @ {json.loads(recorded)['url']}"
