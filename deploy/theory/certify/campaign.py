"""Anytime certification: from large k downwards, slab by slab, until K is reached or time is up."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

from deploy.theory.certify.boxes.scene import Scene, scene_of, whole
from deploy.theory.certify.boxes.search import grow
from deploy.theory.certify.certificate import Certificate, Goals
from deploy.theory.certify.frontier import Frontier, Open
from deploy.theory.function import obstacle_functions
from protocol.errors import UsageError

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
