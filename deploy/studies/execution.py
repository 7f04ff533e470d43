"""Executes the missing runs of a study on all cores, and keeps every result at once.

A worker process executes one run at a time, within itself or as a fleet of processes.
"""

from __future__ import annotations

import json
import multiprocessing
import os
import time
import traceback
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import forkserver, resource_tracker
from multiprocessing.connection import Connection as Channel
from pathlib import Path
from typing import Any

import psutil

from deploy.output import bar, writing
from deploy.processes.fork_server import end_with_pipe
from deploy.run.fleet import Fleet
from deploy.run.local import LocalFleet
from deploy.run.options import RunOptions, Transport
from deploy.run.result import RunResult, complete
from deploy.software import code_digest
from deploy.studies.study import Build, Row, Shard, Study, StudyRun
from protocol.errors import ProcessError
from protocol.process.log import set_process_title
from protocol.process.signals import STOP, Stopped

FAILED = "failed"  # verdict of a run that ended with an exception, which is a bug
# Fields of a result that studies need:
# fmt: off
KEPT = (
    "seed", "verdict", "reason", "arrived", "collisions", "contacts", "min_clearance",
    "nrl", "tight", "k", "robots", "ticks", "sim_time", "wall_time",
    "ticks_per_second", "missed_commands", "down", "positions", "trajectory_sha256", "processes",
)
# fmt: on


def begin(lifeline: Channel[Any, Any]) -> None:
    """Initialise a worker, which ends with the other end of `lifeline`; the parent handles Ctrl-C."""
    set_process_title(f"study worker {multiprocessing.current_process().name.rpartition('-')[2]}")
    end_with_pipe(os.dup(lifeline.fileno()))
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def run_one(build: Build, seed: int, transport: Transport) -> RunResult:
    """Execute one run, and return the fields of its result that studies need.
    Raises ProcessError or BusError if a process of the fleet did not start.
    """
    if transport == "local":
        result = _in_process(build, seed)
    else:
        options = RunOptions(transport)
        with Fleet(build(seed), options) as fleet:
            result = complete(fleet.execute(), options, fleet.processes())
    return {name: result[name] for name in KEPT if name in result}


def _in_process(build: Build, seed: int) -> RunResult:
    began = time.thread_time()
    try:
        report = LocalFleet(build(seed)).execute()
    except Exception:  # noqa: BLE001  a failed run must not end the study
        return {"seed": seed, "verdict": FAILED, "reason": traceback.format_exc(limit=-3)}
    memory = psutil.Process().memory_info().rss / 1e6
    whole = {"name": "local", "cpu_s": time.thread_time() - began, "max_rss_mb": memory}
    return complete(report, RunOptions("local"), [whole])


_POLL = 0.2  # s between checks for signals


@dataclass(frozen=True)
class StudyOutcome:
    """Rows of all cells with results; `complete` unless the study was stopped."""

    rows: list[Row]
    complete: bool


class RunLog:
    """Results by key, in a file with one JSON line per run, or none. `fresh` discards its content.

    A line that a crash cut short is ignored, and its run is executed again.
    Raises UsageError if the file cannot be written.
    """

    def __init__(self, path: Path | None, *, fresh: bool = False) -> None:
        self._path, text = path, ""
        if path is not None and fresh:
            path.unlink(missing_ok=True)
        elif path is not None and path.exists():
            text = path.read_text(encoding="utf-8", errors="replace")
        self.known: dict[str, RunResult] = dict(filter(None, map(_entry, text.splitlines())))
        self._append("\n" if text and not text.endswith("\n") else "")

    def add(self, key: str, result: RunResult) -> None:
        self.known[key] = result
        self._append(json.dumps({"key": key, "result": result}) + "\n")

    def _append(self, text: str) -> None:
        if self._path is not None:
            with writing(self._path, "write results"), self._path.open("a", encoding="utf-8") as file:
                file.write(text)


def _entry(line: str) -> tuple[str, RunResult] | None:
    try:
        entry = json.loads(line)
        return str(entry["key"]), dict(entry["result"])
    except (ValueError, TypeError, KeyError):
        return None


def execute(
    study: Study, transport: Transport, log: RunLog, *, jobs: int, quiet: bool = True, shard: Shard = Shard()
) -> StudyOutcome:
    """Execute the runs of a shard that `log` lacks, `jobs` at a time; after a signal, all finished runs are
    kept.
    Raises ProcessError if a worker or a fleet was lost; repeat the call to continue.
    """
    runs = shard.part(study.runs(transport, code_digest()))
    results = {(run.cell, run.seed): log.known[run.key] for run in runs if run.key in log.known}
    left = [run for run in runs if run.key not in log.known]
    with bar(study.name, silent=quiet) as tell, suppress(Stopped):
        for run, result in _executed(study, left, jobs):
            results[run.cell, run.seed] = result
            if result["verdict"] != FAILED:
                log.add(run.key, result)
            tell(len(results) / len(runs))
    return StudyOutcome(study.rows(results), len(results) == len(runs))


def _executed(study: Study, runs: Sequence[StudyRun], jobs: int) -> Iterator[tuple[StudyRun, RunResult]]:
    waiting: dict[Future[RunResult], StudyRun] = {}
    with _workers(min(jobs, max(1, len(runs)))) as pool:
        try:
            for run in runs:
                waiting[pool.submit(run_one, study.cells[run.cell].build, run.seed, run.transport)] = run
            while waiting and not STOP.requested:
                for future in wait(waiting, _POLL, FIRST_COMPLETED).done:
                    yield waiting.pop(future), future.result()
        except BrokenProcessPool:
            raise ProcessError(
                "a worker ended in the middle of a run; see its output above. Repeat the command to continue"
            ) from None


@contextmanager
def _workers(jobs: int) -> Iterator[ProcessPoolExecutor]:
    """Worker processes, which end at once, with their fleets, when this context or process ends."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["deploy.studies.execution"])
    resource_tracker.ensure_running()  # first, since its start unblocks SIGINT and SIGTERM
    with STOP.held():  # signals are for this process only
        forkserver.ensure_running()
    lifeline, held = context.Pipe(duplex=False)
    with ProcessPoolExecutor(jobs, context, begin, (lifeline,)) as pool:
        try:
            yield pool
        finally:
            held.close()
            pool.shutdown(cancel_futures=True)
