"""The workers of a study: as many processes as jobs; each has one batch at a time."""

from __future__ import annotations

import multiprocessing
from collections import deque
from collections.abc import Iterator, Sequence
from multiprocessing.connection import Connection as Channel
from multiprocessing.connection import wait
from multiprocessing.process import BaseProcess
from typing import Any

from deploy.studies.runners.worker import Batch, Perform, execute, work
from deploy.studies.study import Run
from protocol.errors import ProcessError

Outcome = tuple[Run, dict[str, Any]]


class WorkerPool:
    """A context manager; leaving it ends every worker, and with it whatever that has started."""

    def __init__(self, jobs: int, perform: Perform = execute) -> None:
        context = multiprocessing.get_context("forkserver")
        context.set_forkserver_preload(["deploy.studies.runners.worker"])
        self._workers: dict[Channel[Any, Any], BaseProcess] = {}
        for number in range(jobs):
            ours, theirs = context.Pipe()
            worker = context.Process(
                target=work, args=(theirs, perform), name=f"worker-{number}", daemon=True
            )
            worker.start()
            theirs.close()
            self._workers[ours] = worker

    def __enter__(self) -> WorkerPool:
        return self

    def __exit__(self, *_: object) -> None:
        for channel, worker in self._workers.items():
            channel.close()
            worker.terminate()
        for worker in self._workers.values():
            worker.join()

    def run(self, batches: Sequence[Batch]) -> Iterator[Outcome]:
        """Results of all batches, as they come.

        Raises:
            ProcessError: a worker ended in the middle of a batch; what it said is on standard error.
        """
        waiting = deque(batches)
        busy: set[Channel[Any, Any]] = set()
        for channel in self._workers:
            _give(channel, waiting, busy)
        while busy:
            for ready in wait(list(busy)):
                channel = next(each for each in busy if each is ready)
                outcome = self._receive(channel)
                if outcome is not None:
                    yield outcome
                else:
                    busy.discard(channel)
                    _give(channel, waiting, busy)

    def _receive(self, channel: Channel[Any, Any]) -> Outcome | None:
        try:
            outcome: Outcome | None = channel.recv()
        except (EOFError, ConnectionError):
            worker = self._workers[channel]
            worker.join()
            raise ProcessError(
                f"{worker.name} ended with status {worker.exitcode}; what it said stands above. "
                "The same command goes on from what is done"
            ) from None
        return outcome


def _give(channel: Channel[Any, Any], waiting: deque[Batch], busy: set[Channel[Any, Any]]) -> None:
    if waiting:
        channel.send(waiting.popleft())
        busy.add(channel)
