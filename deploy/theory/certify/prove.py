"""`disknav certify`: proves slab by slab from large k downwards, until K is reached or time is up.

The same call continues below the slabs of an earlier one.
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

from deploy.theory.certify.boxes import scene_of
from deploy.theory.certify.certificate import Certificate, GoalSet, Trial, fetch, path_for, store
from deploy.theory.certify.search import Search
from deploy.theory.function import obstacle_functions
from protocol.errors import UsageError
from protocol.process.signals import STOP
from protocol.scenario.model import Scenario

LADDER = (1000.0, 300.0, 100.0, 50.0, 30.0, 20.0, 15.0, 12.0, 10.0, 8.0, 6.0, 5.0, 4.0)
_FINER = 0.9  # ratio below the ladder
_LOWEST = 1.0
_TRIAL = 1e-3
_PORTION = 20_000  # nodes between checks of the clock


def ladder(above: float | None, target: float | None) -> Iterator[float]:
    """The values of k to prove in turn: below `above`, down to `target`, if given."""
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
        tell: called with the certificate after each change; False stops.

    Raises:
        UsageError: goals overlap, touch or are not inside the workspace; or `target` is not positive.
    """
    require_free(certificate.goals)
    scene = scene_of(certificate.goals.problem)
    Search(scene, (0.0, _TRIAL)).advance(1)  # compile outside of the measured time
    proven = certificate.proven
    if target is not None and proven is not None and proven <= target:
        return
    for k in ladder(proven, target):
        search, began = Search(scene, certificate.kappa(k)), time.process_time()
        while search.advance(_PORTION):
            certificate.trial = Trial(k, search.done, search.nodes)
            if not tell(certificate):
                return
        if search.stuck:
            return
        certificate.add(k, search.branching, time.process_time() - began)
        if not tell(certificate):
            return


def require_free(goals: GoalSet) -> None:
    """Raises UsageError unless the goals are in the interior of free space."""
    problem = goals.problem
    if not (obstacle_functions(problem, problem.goals) > 0.0).all():
        raise UsageError("goals that touch, overlap or are not inside the workspace have no certificate")


@dataclass(frozen=True)
class ProofRequest:
    """Options of a proof. target: K; None for as far down as `minutes` allow."""

    name: str
    target: float | None
    minutes: float
    file: Path | None = None
    quiet: bool = False

    @property
    def path(self) -> Path:
        """Path of the certificate."""
        return self.file or path_for(self.name)


@dataclass(frozen=True)
class ProofOutcome:
    """The present certificate; interrupted: by Ctrl-C."""

    certificate: Certificate
    path: Path
    target: float | None
    interrupted: bool

    @property
    def proven(self) -> bool:
        """Whether the requested K, or without one any K, is proven."""
        found = self.certificate.proven
        return found is not None and (self.target is None or found <= self.target)


def certify(scenario: Scenario, request: ProofRequest) -> ProofOutcome:
    """Extend the certificate of a scenario's goals until the request is met or time is up.

    Raises:
        ProofError: the file is damaged, or belongs to other goals.
        UsageError: the goals cannot have a certificate.
    """
    goals = GoalSet.of(scenario)
    certificate = fetch(request.path, goals) if request.path.exists() else Certificate(goals, scenario.name)
    with _Keeper(certificate, request) as keeper:
        prove(certificate, request.target, keeper.tell)
    return ProofOutcome(certificate, request.path, request.target, STOP.requested)


class _Keeper:
    """Writes the file after each slab and at the end, shows a progress bar, and watches the time."""

    def __init__(self, certificate: Certificate, request: ProofRequest) -> None:
        self._certificate, self._path = certificate, request.path
        self._until = time.monotonic() + 60.0 * request.minutes
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
        """Update file and bar; False once time is up, or after a signal."""
        trial = certificate.trial
        done, boxes = (1.0, 0) if trial is None else (trial.done, trial.boxes)
        proven = "" if certificate.proven is None else f"k ≥ {certificate.proven:g} proven"
        trying = "" if trial is None else f"trying {trial.k:g}"
        text = ", ".join(part for part in (proven, trying) if part)
        self._progress.update(self._task, completed=done, description=text, boxes=certificate.boxes + boxes)
        if trial is None:
            store(certificate, self._path)
        return time.monotonic() < self._until and not STOP.requested


def to_json(outcome: ProofOutcome) -> dict[str, Any]:
    found = outcome.certificate
    return {
        "scenario": found.scenario,
        "robots": len(found.goals.radii),
        "asked": outcome.target,
        "proven": found.proven,
        "boxes": found.boxes,
        "seconds": found.time,
        "slabs": [{"k": slab.k, "boxes": slab.boxes, "seconds": slab.seconds} for slab in found.slabs],
        "unfinished": None if found.trial is None else found.trial._asdict(),
        "interrupted": outcome.interrupted,
        "file": str(outcome.path),
    }
