"""A Dask cluster in place of this process: open boxes as tasks, what is left of them as new ones."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import TYPE_CHECKING

from deploy.software.scheduler import connected, finished, result
from deploy.theory.certify.boxes.scene import Scene
from deploy.theory.certify.boxes.search import grow
from deploy.theory.certify.campaign import widen
from deploy.theory.certify.frontier import Frontier, Grown, Open

if TYPE_CHECKING:
    from distributed import Future

    _Task = Future[tuple[Grown, float]]

_NODES = 100_000  # a task; what is lost with a worker, or with Ctrl-C, is at most this
_SHARES = 4  # open boxes for each thread of the cluster


class Spread:
    """Works on every open box at once, as far as there are threads; Dask repeats what a worker loses."""

    def __init__(self, address: str) -> None:
        """Connect to the scheduler at `address`, such as `tcp://10.0.0.1:8786`.

        Raises:
            UsageError: the library is missing, or `address` is none.
            ProcessError: no scheduler answers there.
        """
        self._client = connected(address)

    def work(self, scene: Scene, frontier: Frontier) -> Iterator[float]:
        """Until nothing is open; leaving early cancels what is outstanding.

        Raises:
            ProcessError: the scheduler, or all workers, are gone, or a task failed.
        """
        given: dict[_Task, Open] = {}
        try:
            while frontier.open:
                self._give(scene, frontier, given)
                yield sum(self._take(frontier, future, given) for future in finished(self._client, given))
        finally:
            self._client.cancel(list(given), force=True)

    def _give(self, scene: Scene, frontier: Frontier, given: dict[_Task, Open]) -> None:
        """Keep every thread busy: few open boxes are halved here first."""
        if not given:
            widen(scene, frontier, _SHARES * max(1, sum(self._client.nthreads().values())))
        held = {id(root) for root in given.values()}
        for root in frontier.open:
            if id(root) not in held:
                future = self._client.submit(perform, scene, root, frontier.kappa[1], pure=False)
                given[future] = root

    def _take(self, frontier: Frontier, future: _Task, given: dict[_Task, Open]) -> float:
        grown, seconds = result(self._client, future)
        frontier.put(given.pop(future), grown)
        return seconds


def perform(scene: Scene, root: Open, kappa: float) -> tuple[Grown, float]:
    """One task, in a worker: the branching and the processor seconds that it took."""
    began = time.process_time()
    return grow(scene, root, kappa, _NODES), time.process_time() - began
