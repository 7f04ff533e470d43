"""A Dask cluster in place of this process: open boxes as tasks, what is left of them as new ones."""

from __future__ import annotations

import time
from collections.abc import Iterator
from concurrent.futures import CancelledError
from typing import TYPE_CHECKING

from deploy.software.scheduler import connected
from deploy.theory.certify.boxes.scene import Scene
from deploy.theory.certify.boxes.search import grow
from deploy.theory.certify.campaign import widen
from deploy.theory.certify.frontier import Frontier, Grown, Open
from protocol.errors import ProcessError

if TYPE_CHECKING:
    from distributed import Future

    _Task = Future[tuple[Grown, float]]

_NODES = 100_000  # a task; what is lost with a worker, or with Ctrl-C, is at most this
_SHARES = 4  # open boxes for each thread of the cluster
_LOOK = 1.0  # s
_DESERTED = 60.0  # s without any worker


class Spread:
    """Works on every open box at once, as far as there are threads; Dask repeats what a worker loses."""

    def __init__(self, address: str) -> None:
        """Connect to the scheduler at `address`, such as `tcp://10.0.0.1:8786`.

        Raises:
            UsageError: the library is missing, or `address` is none.
            ProcessError: no scheduler answers there.
        """
        self._address, self._client = address, connected(address)

    def work(self, scene: Scene, frontier: Frontier) -> Iterator[float]:
        """Until nothing is open; leaving early cancels what is outstanding.

        Raises:
            ProcessError: the scheduler, or all workers, are gone, or a task failed.
        """
        given: dict[_Task, Open] = {}
        try:
            while frontier.open:
                self._give(scene, frontier, given)
                yield sum(self._take(frontier, future, given) for future in self._next(given))
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

    def _next(self, given: dict[_Task, Open]) -> list[_Task]:
        """Those that are done, as soon as there is one; nothing, to look around, after a while."""
        from distributed import TimeoutError as NoneYet
        from distributed import wait

        deserted = 0.0
        while given and deserted < _DESERTED:
            try:
                with self._client.as_current():
                    return list(wait(list(given), timeout=_LOOK, return_when="FIRST_COMPLETED").done)
            except NoneYet:
                deserted = 0.0 if self._client.nthreads() else deserted + _LOOK
            except CancelledError:
                raise self._lost("the scheduler is gone") from None
        if given:
            raise self._lost(f"no worker for {_DESERTED:g} s")
        return []

    def _take(
        self,
        frontier: Frontier,
        future: _Task,
        given: dict[_Task, Open],
    ) -> float:
        root = given.pop(future)
        try:
            grown, seconds = future.result()
        except CancelledError:
            raise self._lost("the scheduler is gone") from None
        except Exception as error:
            raise self._lost(f"a worker could not do its part: {error!r}") from error
        frontier.put(root, grown)
        return seconds

    def _lost(self, why: str) -> ProcessError:
        return ProcessError(
            f"the cluster at {self._address}: {why}; the same command goes on from what is done"
        )


def perform(scene: Scene, root: Open, kappa: float) -> tuple[Grown, float]:
    """One task, in a worker: the branching and the processor seconds that it took."""
    began = time.process_time()
    return grow(scene, root, kappa, _NODES), time.process_time() - began
