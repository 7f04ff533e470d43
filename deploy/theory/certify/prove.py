"""`disknav certify`: proves slab by slab from large k downwards, until K is reached or time is up.

The same call continues below the slabs of an earlier one.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from msgspec import UNSET

from deploy.output import bar
from deploy.theory.certify.boxes import scene_of
from deploy.theory.certify.certificate import BLOCKED, MOST_ROBOTS, Certificate, GoalSet, Trial, fetch, store
from deploy.theory.certify.search import Search
from protocol.errors import UsageError
from protocol.process.signals import STOP, Stopped
from protocol.scenario.model import Scenario

_FINER = tuple(float(f"{4.0 * 0.9**n:.3g}") for n in range(14))  # 4 to 1.02
LADDER = (1000.0, 300.0, 100.0, 50.0, 30.0, 20.0, 15.0, 12.0, 10.0, 8.0, 6.0, 5.0, *_FINER)
_TRIAL = 1e-3
_PORTION = 200  # nodes between checks of the clock, 0.1 s for seven robots


def ladder(above: float | None, target: float | None) -> list[float]:
    """The values of k to prove in turn: below `above`, down to `target`, if given."""
    rungs = [k for k in LADDER if (above is None or k < above) and (target is None or k > target)]
    return rungs if target is None else [*rungs, target]


def prove(certificate: Certificate, target: float | None) -> Iterator[Certificate]:
    """Extend a certificate down to `target`, or as far as possible; yields it after each change.
    Raises UsageError if goals overlap, touch or are not inside the workspace, or `target` is not positive and
    finite.
    """
    if not certificate.goals.is_free:
        raise UsageError(BLOCKED)
    if target is not None and not 0.0 < target < math.inf:
        raise UsageError(f"k is {target:g}: a certificate is for every k from a positive number on")
    scene = scene_of(certificate.goals.problem)
    Search(scene, (0.0, _TRIAL)).advance(1)  # compile outside of the measured time
    if target is not None and certificate.proves(target):
        return
    for k in ladder(certificate.proven, target):
        search, began = Search(scene, certificate.kappa(k)), time.process_time()
        while search.advance(_PORTION):
            certificate.trial = Trial(k, search.done, search.nodes)
            yield certificate
        if search.stuck:
            return
        certificate.add(k, search.branching, time.process_time() - began)
        yield certificate


def certify(
    scenario: Scenario, path: Path, target: float | None, minutes: float, *, quiet: bool = False
) -> Certificate:
    """Extend the certificate of a scenario's goals in `path` until `target` is proven or time is up.

    The file is written after each slab and at the end, also after a signal.

    Raises:
        ProofError: the file is damaged, or belongs to other goals.
        UsageError: the goals cannot have a certificate, or there are too many.
    """
    if len(scenario.ids) > MOST_ROBOTS:
        raise UsageError(f"{scenario.name}: no certificate for more than {MOST_ROBOTS} robots")
    goals = GoalSet.of(scenario)
    certificate = fetch(path, goals) if path.exists() else Certificate(goals=goals, scenario=scenario.name)
    until = time.monotonic() + 60.0 * minutes
    with bar("compiling", silent=quiet) as show, suppress(Stopped):
        for found in prove(certificate, target):
            if found.trial is UNSET:
                store(found, path)
            show(1.0 if found.trial is UNSET else found.trial.done, _state(found))
            if time.monotonic() >= until:
                break
    store(certificate, path)
    return certificate


def _state(found: Certificate) -> str:
    proven = "" if found.proven is None else f"k ≥ {found.proven:g} proven, "
    if found.trial is UNSET:
        return f"{proven}{found.boxes:,} boxes"
    return f"{proven}trying {found.trial.k:g}, {found.boxes + found.trial.boxes:,} boxes"


def to_json(found: Certificate, path: Path, target: float | None) -> dict[str, Any]:
    return {
        "scenario": found.scenario,
        "robots": len(found.goals.radii),
        "asked": target,
        "proven": found.proven,
        "boxes": found.boxes,
        "seconds": found.time,
        "slabs": [{"k": slab.k, "boxes": slab.boxes, "seconds": slab.seconds} for slab in found.slabs],
        "unfinished": None if found.trial is UNSET else found.trial._asdict(),
        "interrupted": STOP.requested,
        "file": str(path),
    }
