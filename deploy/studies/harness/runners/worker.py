"""A worker of a study: a process that is given batches of runs and gives back their results.

In-process runs follow each other in the worker itself. On real processes a batch is one fleet whose
processes go from run to run, so that only the first run pays for starting them.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
import traceback
from collections.abc import Callable, Sequence
from multiprocessing.connection import Connection as Channel
from typing import Any

import psutil

from deploy.processes.forked import end_with_pipe
from deploy.run.fleet import Fleet
from deploy.run.options import RunOptions
from deploy.run.outcome.result import complete
from deploy.studies.harness.runners.metered import MeteredFleet
from deploy.studies.harness.study import Build, Run
from protocol.errors import ProcessError
from protocol.process.title import entitle

Result = dict[str, Any]
Outcome = tuple[Run, Result]
Job = tuple[Run, Build]
Send = Callable[[Run, Result], None]
Batch = Sequence[tuple[Run, Any]]  # runs, each with what `Perform` needs of it
Perform = Callable[[Batch, Send], None]

FAILED = "failed"  # verdict of a run that ended with an exception: a bug, never a result
# Of a result, which says more than a study needs:
# fmt: off
KEPT = (
    "seed", "verdict", "reason", "arrived", "collisions", "contacts", "min_clearance",
    "nrl", "tight", "k", "robots", "ticks", "sim_time", "wall_time",
    "ticks_per_second", "missed_commands", "down", "positions", "trajectory_sha256", "cpu_s", "robots_cpu_s",
    "max_rss_mb", "processes",
)
# fmt: on


def begin(lifeline: Channel[Any, Any]) -> None:
    """Have this process end with the other end of `lifeline`; what a Ctrl-C means, the parent says."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    entitle(f"study worker {multiprocessing.current_process().name.rpartition('-')[2]}")
    end_with_pipe(os.dup(lifeline.fileno()))
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def outcomes(batch: Batch, perform: Perform, check: Callable[[], None] = lambda: None) -> list[Outcome]:
    """All results of a batch; `check` is called after each run, and may end it by an exception."""
    found: list[Outcome] = []

    def send(run: Run, result: Result) -> None:
        found.append((run, result))
        check()

    perform(batch, send)
    return found


def kept(result: Result) -> Result:
    """What a study needs of a result."""
    return {name: result[name] for name in KEPT if name in result}


def execute(batch: Sequence[Job], send: Send) -> None:
    """Run a batch: all on one transport, and with the same robot ids unless it is in-process.

    Raises:
        ProcessError: a fleet ended before its last run.
    """
    if batch[0][0].transport == "local":
        for run, build in batch:
            send(run, kept(_in_process(run, build)))
    else:
        _on_fleet(batch, send)


def _in_process(run: Run, build: Build) -> Result:
    began = time.thread_time()
    try:
        fleet = MeteredFleet([build(run.seed)])
        (report,) = fleet.execute()
    except Exception:  # noqa: BLE001  one run that fails must be reported beside the thousands that do not
        return {"seed": run.seed, "verdict": FAILED, "reason": traceback.format_exc(limit=-3)}
    result = complete(report, RunOptions("local"), [])
    result["cpu_s"] = time.thread_time() - began
    result["robots_cpu_s"] = fleet.robots_cpu()
    result["max_rss_mb"] = psutil.Process().memory_info().rss / 2**20
    return result


def _on_fleet(batch: Sequence[Job], send: Send) -> None:
    options = RunOptions(batch[0][0].transport)
    waiting = iter([run for run, _ in batch])
    alone = len(batch) == 1  # then what its processes cost belongs to it

    def on_report(report: Result) -> None:
        if not alone:
            send(next(waiting), kept(complete(report, options, [])))

    with Fleet([build(run.seed) for run, build in batch], options, on_report=on_report) as fleet:
        reports = fleet.execute()
        processes = fleet.processes()
    if len(reports) < len(batch):
        done = f"{len(reports)} of {len(batch)} runs"
        raise ProcessError(f"the fleet ended after {done}: {reports[-1]['reason']}")
    if alone:
        send(batch[0][0], kept(complete(reports[0], options, processes)))
