"""The workers of a Dask cluster, in place of processes of this machine: a worker pool at large.

A task is one batch. Dask gives a batch whose worker is lost to another one, and hands over each batch's
results once, so no row is lost and none comes twice.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import count
from typing import TYPE_CHECKING

from deploy.run.options import fresh_run_name
from deploy.software.provenance import code_digest
from deploy.software.scheduler import connected, finished, result
from deploy.studies.harness.runners.worker import Batch, Outcome, Perform, execute, outcomes
from protocol.errors import DisknavError, ProcessError

if TYPE_CHECKING:
    from distributed import Future

_GATHERING = 10.0  # s for it to have a worker


class Cluster:
    """A context manager; leaving it cancels whatever is outstanding."""

    def __init__(self, address: str, perform: Perform = execute) -> None:
        """Connect to the scheduler at `address`, such as `tcp://10.0.0.1:8786`; `perform` is what it is for.

        Raises:
            UsageError: the library is missing, or `address` is none.
            ProcessError: no scheduler answers there, or it has no workers.
        """
        self._address, self._perform = address, perform
        self._name = fresh_run_name()
        self._number = count()
        self._client = connected(address)
        self._given: list[Future[list[Outcome]]] = []
        self._await_workers()

    def __enter__(self) -> Cluster:
        return self

    def __exit__(self, *_: object) -> None:
        """Cancel what has not begun; what has, ends with the run that it is in."""
        from distributed import Event

        if self._client.status == "running" and not all(future.done() for future in self._given):
            Event(self._name, client=self._client).set()
            self._client.cancel(self._given, force=True)
        self._client.close()

    def run(self, batches: Sequence[Batch]) -> Iterator[Outcome]:
        """Results of all batches, as they come.

        Raises:
            ProcessError: a batch failed, the scheduler is gone, or all workers are.
        """
        self._given = self._submitted(batches)
        waiting = set(self._given)
        while waiting:
            done = finished(self._client, waiting)
            waiting.difference_update(done)
            for future in done:
                yield from result(self._client, future)
                future.release()

    def _submitted(self, batches: Sequence[Batch]) -> list[Future[list[Outcome]]]:
        arguments = code_digest(), self._name, self._perform
        return [
            self._client.submit(within_dask, batch, *arguments, key=f"{self._name}-{next(self._number)}")
            for batch in batches
        ]

    def _await_workers(self) -> None:
        from distributed import TimeoutError as NoneYet

        try:
            self._client.wait_for_workers(1, timeout=_GATHERING)
        except NoneYet:
            self._client.close()
            raise ProcessError(
                f"the scheduler at {self._address} has no workers: start some with "
                f"`dask worker {self._address} --nthreads 1`"
            ) from None


def within_dask(batch: Batch, digest: str, stop: str, perform: Perform) -> list[Outcome]:
    """Run a batch in a worker.

    Args:
        perform: what is done with it.
        digest: of the code that the results are to come from.
        stop: name of an event; once it is set, nobody waits for the results any more.

    Raises:
        ProcessError: the worker has other code, or a fleet was lost.
    """
    from distributed import Event, get_worker

    if code_digest() != digest:
        raise ProcessError(
            f"the worker at {get_worker().address} has another version of disknav: "
            "install the same everywhere"
        )
    stopped = Event(stop)

    def check() -> None:
        if stopped.is_set():
            raise StudyStoppedError("the study was stopped")

    return outcomes(batch, perform, check)


class StudyStoppedError(DisknavError):
    """Nobody waits for this batch any more."""
