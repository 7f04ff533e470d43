"""`disknav certify`: from large k downwards, slab by slab, until K is reached or time is up.

The same call goes on from the file that an earlier one left.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from deploy.theory.certify.boxes import Scene, scene_of, whole
from deploy.theory.certify.certificate import Certificate, Frontier, Goals, Open, fetch, path_for, store
from deploy.theory.certify.search import grow
from deploy.theory.function import obstacle_functions
from protocol.errors import UsageError
from protocol.process.signals import STOP
from protocol.scenario.model import Scenario

LADDER = (1000.0, 300.0, 100.0, 50.0, 30.0, 20.0, 15.0, 12.0, 10.0, 8.0, 6.0, 5.0, 4.0)
_FINER = 0.9  # ratio below the ladder
_LOWEST = 1.0
_TRIAL = 1e-3
_PORTION = 20_000  # nodes between looks at the clock


def beginning(scene: Scene, kappa: tuple[float, float]) -> Frontier:
    """Everything is open."""
    return Frontier(kappa, [Open(whole(scene, kappa), 0)])


def advance(scene: Scene, frontier: Frontier, nodes: int) -> None:
    """Work on the first open box."""
    root = frontier.open[0]
    frontier.put(root, grow(scene, root, frontier.kappa[1], nodes))


def ladder(above: float | None, target: float | None) -> Iterator[float]:
    """The k to prove next, one after the other: below `above`, if given, and down to `target`, if given."""
    for k in _steps():
        if above is not None and k >= above:
            continue
        if target is not None and k <= target:
            yield target
            return
        yield k


def _steps() -> Iterator[float]:
    yield from LADDER
    k = LADDER[-1] * _FINER
    while k > _LOWEST:
        yield float(f"{k:.3g}")
        k *= _FINER


def prove(
    certificate: Certificate,
    target: float | None,
    tell: Callable[[Certificate], bool],
) -> None:
    """Extend a certificate down to `target`, or as far as possible.

    Args:
        tell: is given the certificate whenever something has changed; False stops.

    Raises:
        UsageError: two goals overlap or touch, or one is not inside the workspace; or target is not positive.
    """
    require_free(certificate.goals)
    scene = scene_of(certificate.goals.problem)
    grow(scene, Open(whole(scene, (0.0, _TRIAL)), 0), _TRIAL, 1)  # compiles, outside of the time that counts
    if certificate.k is not None and target is not None and certificate.k < target:
        certificate.k, certificate.frontier = None, None  # further down than is asked for now
    for k in _remaining(certificate, target):
        if certificate.frontier is None:
            certificate.begin(k, beginning(scene, certificate.kappa(k)))
        assert certificate.frontier is not None
        while certificate.frontier.open:
            began = time.process_time()
            advance(scene, certificate.frontier, _PORTION)
            certificate.seconds += time.process_time() - began
            if not tell(certificate):
                return
        certificate.finish()
        if not tell(certificate):
            return


def _remaining(certificate: Certificate, target: float | None) -> Iterator[float]:
    proven = certificate.proven
    if target is not None and proven is not None and proven <= target:
        return
    above = proven
    if certificate.k is not None:
        above = certificate.k
        yield above
        if target is not None and above <= target:
            return
    yield from ladder(above, target)


def require_free(goals: Goals) -> None:
    """Refuse goals that are not in the interior of free space.

    Raises:
        UsageError: says so.
    """
    problem = goals.problem
    if not (obstacle_functions(problem, problem.goals) > 0.0).all():
        raise UsageError("goals that touch, overlap or are not inside the workspace have no certificate")


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
    with _Keeper(certificate, request) as keeper:
        prove(certificate, request.target, keeper.tell)
    return Outcome(certificate, request.path, request.target, STOP.requested)


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
        """Whether there is time left, and no signal asks this process to end."""
        frontier = certificate.frontier
        done, boxes = (1.0, 0) if frontier is None else (frontier.done, frontier.nodes)
        proven = "" if certificate.proven is None else f"k ≥ {certificate.proven:g} proven"
        trying = "" if certificate.k is None else f"trying {certificate.k:g}"
        text = ", ".join(part for part in (proven, trying) if part)
        self._progress.update(self._task, completed=done, description=text, boxes=certificate.boxes + boxes)
        if frontier is None or time.monotonic() > self._kept + _KEEP:
            store(certificate, self._path)
            self._kept = time.monotonic()
        return time.monotonic() < self._until and not STOP.requested


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
