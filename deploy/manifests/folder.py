"""The folder that `disknav setup deploy` leaves: an orchestrator's files, and the keys."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from shutil import rmtree
from tempfile import mkdtemp
from typing import Literal

from deploy.manifests import render
from deploy.manifests.plan import KEYS, Plan
from protocol.errors import UsageError

Orchestrator = Literal["compose", "kubernetes", "systemd"]


def write(folder: Path, orchestrator: Orchestrator, plan: Plan, days: float = 30.0) -> None:
    """Make `folder` with all that `orchestrator` needs; it appears whole or not at all, for its owner only.

    Raises:
        UsageError: there is something in it already, or a library is missing.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise UsageError(f"{folder} exists and is not empty: name another folder")
    from deploy.security.keystore import create

    folder.parent.mkdir(parents=True, exist_ok=True)
    fresh = Path(mkdtemp(prefix=f".{folder.name}-", dir=folder.parent))  # mode 0700
    try:
        create(fresh / KEYS, plan.roster, hosts=(render.router_host(orchestrator, plan),), days=days)
        for name, text in _files(orchestrator, plan, fresh / KEYS).items():
            path = fresh / name
            path.touch(mode=0o600 if name == render.SECRET else 0o644)
            path.write_text(text, encoding="utf-8")
        fresh.rename(folder)
    except BaseException:
        rmtree(fresh, ignore_errors=True)
        raise


def _files(orchestrator: Orchestrator, plan: Plan, keys: Path) -> Mapping[str, str]:
    if orchestrator == "compose":
        return render.compose(plan)
    if orchestrator == "kubernetes":
        return render.kubernetes(plan, {path.name: path.read_bytes() for path in keys.iterdir()})
    return render.systemd(plan)
