"""One call of `disknav certify`: goes on from the file, shows how far it is, keeps what is done."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from deploy.theory.certify.campaign import prove
from deploy.theory.certify.certificate import Certificate, Goals, fetch, path_for, store
from protocol.scenario.model import Scenario

_KEEP = 20.0  # s between writing the file


@dataclass(frozen=True)
class Request:
    """What is asked for. target: K, None for as far down as `minutes` reach."""

    name: str
    target: float | None
    minutes: float
    file: Path | None = None
    quiet: bool = False

    @property
    def path(self) -> Path:
        """Of the certificate."""
        return self.file or path_for(self.name)


@dataclass(frozen=True)
class Outcome:
    """The certificate as it is now; interrupted: by Ctrl-C."""

    certificate: Certificate
    path: Path
    target: float | None
    interrupted: bool

    @property
    def proven(self) -> bool:
        """Whether what was asked for is proven: K, or without one anything."""
        found = self.certificate.proven
        return found is not None and (self.target is None or found <= self.target)


def certify(scenario: Scenario, request: Request) -> Outcome:
    """Extend the certificate of a scenario's goals, until what was asked for is proven or time is up.

    Raises:
        ProofError: the file is damaged, or of other goals.
        UsageError: the goals cannot have a certificate.
    """
    goals = Goals.of(scenario)
    certificate = fetch(request.path, goals) if request.path.exists() else Certificate(goals, scenario.name)
    interrupted = False
    with _Keeper(certificate, request) as keeper:
        try:
            prove(certificate, request.target, keeper.tell)
        except KeyboardInterrupt:
            interrupted = True
    return Outcome(certificate, request.path, request.target, interrupted)


class _Keeper:
    """Writes the file now and then and at the end, shows a bar, and says when time is up."""

    def __init__(self, certificate: Certificate, request: Request) -> None:
        self._certificate, self._path = certificate, request.path
        self._until = time.monotonic() + 60.0 * request.minutes
        self._kept = time.monotonic()
        columns = (
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.percentage:5.1f} %  {task.fields[boxes]:,} boxes"),
            TimeElapsedColumn(),
        )
        self._progress = Progress(
            *columns, console=Console(stderr=True), transient=True, disable=request.quiet
        )
        self._task = self._progress.add_task("compiling", total=1.0, boxes=0)

    def __enter__(self) -> _Keeper:
        self._progress.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._progress.stop()
        store(self._certificate, self._path)

    def tell(self, certificate: Certificate) -> bool:
        """Whether there is time left."""
        frontier = certificate.frontier
        done, boxes = (1.0, 0) if frontier is None else (frontier.done, frontier.nodes)
        proven = "" if certificate.proven is None else f"k ≥ {certificate.proven:g} proven"
        trying = "" if certificate.k is None else f"trying {certificate.k:g}"
        text = ", ".join(part for part in (proven, trying) if part)
        self._progress.update(self._task, completed=done, description=text, boxes=certificate.boxes + boxes)
        if frontier is None or time.monotonic() > self._kept + _KEEP:
            store(certificate, self._path)
            self._kept = time.monotonic()
        return time.monotonic() < self._until


def to_json(outcome: Outcome) -> dict[str, Any]:
    """Plain data."""
    found = outcome.certificate
    frontier = found.frontier
    unfinished = None if frontier is None else {"k": found.k, "done": frontier.done, "boxes": frontier.nodes}
    return {
        "scenario": found.scenario,
        "robots": len(found.goals.radii),
        "asked": outcome.target,
        "proven": found.proven,
        "boxes": found.boxes,
        "seconds": found.time,
        "slabs": [{"k": slab.k, "boxes": slab.boxes, "seconds": slab.seconds} for slab in found.slabs],
        "unfinished": unfinished,
        "interrupted": outcome.interrupted,
        "file": str(outcome.path),
    }
