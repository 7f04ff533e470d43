"""The workers of a study: as many processes as jobs; each has one batch at a time."""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool

from deploy.studies.harness.runners.worker import Batch, Outcome, Perform, begin, execute, outcomes
from protocol.errors import ProcessError


class WorkerPool:
    """A context manager; leaving it ends every worker, and with it whatever that has started.

    So does the end of this process, whatever ends it.
    """

    def __init__(self, jobs: int, perform: Perform = execute) -> None:
        context = multiprocessing.get_context("forkserver")
        context.set_forkserver_preload(["deploy.studies.harness.runners.worker"])
        lifeline, self._held = context.Pipe(duplex=False)
        self._perform = perform
        self._executor = ProcessPoolExecutor(jobs, context, begin, (lifeline,))

    def __enter__(self) -> WorkerPool:
        return self

    def __exit__(self, *_: object) -> None:
        self._held.close()  # in the middle of a batch, too
        self._executor.shutdown(cancel_futures=True)

    def run(self, batches: Sequence[Batch]) -> Iterator[Outcome]:
        """Results of all batches, as they come.

        Raises:
            ProcessError: a worker ended in the middle of a batch; what it said is on standard error.
        """
        try:
            futures = [self._executor.submit(outcomes, batch, self._perform) for batch in batches]
            for future in as_completed(futures):
                yield from future.result()
        except BrokenProcessPool:
            raise ProcessError(
                "a worker ended in the middle of a batch; see its output above. "
                "The same command goes on from what is done"
            ) from None
