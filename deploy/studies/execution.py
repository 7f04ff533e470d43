"""Executes a study: the runs that are not done yet, on all cores; every result is kept at once."""

from __future__ import annotations

import json
import multiprocessing
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import forkserver
from pathlib import Path

from deploy.output.bar import bar
from deploy.run.options import Transport
from deploy.software.provenance import code_digest
from deploy.studies.study import Result, Row, Run, Shard, Study
from deploy.studies.worker import FAILED, begin
from deploy.studies.worker import execute as perform
from protocol.errors import ProcessError
from protocol.process.signals import STOP, Stopped

_POLL = 0.2  # s between looks at whether a signal came


@dataclass(frozen=True)
class Outcome:
    """Rows of the cells that have results; `complete` unless the study was stopped."""

    rows: list[Row]
    complete: bool
    executed: int  # runs of this call
    reused: int  # runs known from before


class RunLog:
    """Results by key in a file of one JSON line a run, which only grows; a context manager.

    A line that a crash cut short is ignored, and its run is executed again.

    Args:
        path: None keeps nothing.
        fresh: forget what the file holds.
    """

    def __init__(self, path: Path | None, *, fresh: bool = False) -> None:
        text = ""
        if path is not None and path.exists() and not fresh:
            text = path.read_text(encoding="utf-8", errors="replace")
        self.known: dict[str, Result] = dict(filter(None, map(_entry, text.splitlines())))
        self._file = None if path is None else path.open("w" if fresh else "a", encoding="utf-8")
        if self._file is not None and text and not text.endswith("\n"):
            self._file.write("\n")

    def __enter__(self) -> RunLog:
        return self

    def __exit__(self, *_: object) -> None:
        if self._file is not None:
            self._file.close()

    def add(self, key: str, result: Result) -> None:
        """Keep one result."""
        self.known[key] = result
        if self._file is not None:
            self._file.write(json.dumps({"key": key, "result": result}) + "\n")
            self._file.flush()


def _entry(line: str) -> tuple[str, Result] | None:
    try:
        entry = json.loads(line)
        return str(entry["key"]), dict(entry["result"])
    except (ValueError, TypeError, KeyError):
        return None


def execute(
    study: Study, transport: Transport, log: RunLog, *, jobs: int, quiet: bool = True, shard: Shard = Shard()
) -> Outcome:
    """Execute the runs of a shard that `log` does not know; a signal keeps all that are done.

    Args:
        jobs: runs at the same time.

    Raises:
        ProcessError: a worker or a fleet was lost; the same call goes on from there.
    """
    runs = shard.part(study.runs(transport, code_digest()))
    results = {(run.cell, run.seed): log.known[run.key] for run in runs if run.key in log.known}
    left = [run for run in runs if run.key not in log.known]
    reused = len(results)
    with bar(study.name, silent=quiet) as tell, suppress(Stopped):
        for run, result in _executed(study, left, jobs):
            results[run.cell, run.seed] = result
            if result["verdict"] != FAILED:
                log.add(run.key, result)
            tell(len(results) / len(runs))
    return Outcome(study.rows(results), len(results) == len(runs), len(results) - reused, reused)


def _executed(study: Study, runs: Sequence[Run], jobs: int) -> Iterator[tuple[Run, Result]]:
    """Runs and their results, as they end, until a signal asks this process to end."""
    waiting: dict[Future[Result], Run] = {}
    with _workers(min(jobs, max(1, len(runs)))) as pool:
        try:
            for run in runs:
                waiting[pool.submit(perform, study.cells[run.cell].build, run.seed, run.transport)] = run
            while waiting and not STOP.requested:
                for future in wait(waiting, _POLL, FIRST_COMPLETED).done:
                    yield waiting.pop(future), future.result()
        except BrokenProcessPool:
            raise ProcessError(
                "a worker ended in the middle of a run; see its output above. "
                "The same command goes on from what is done"
            ) from None


@contextmanager
def _workers(jobs: int) -> Iterator[ProcessPoolExecutor]:
    """Worker processes, which end at once with this context or this process, and their fleets with them."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["deploy.studies.worker"])
    with STOP.held():  # what a signal means, this process says
        forkserver.ensure_running()
    lifeline, held = context.Pipe(duplex=False)
    with ProcessPoolExecutor(jobs, context, begin, (lifeline,)) as pool:
        try:
            yield pool
        finally:
            held.close()
            pool.shutdown(cancel_futures=True)
