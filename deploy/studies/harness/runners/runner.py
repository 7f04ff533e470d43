"""Executes a study: what is not done yet, on all cores or on a cluster, and every result kept at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from deploy.run.options import Transport
from deploy.software.provenance import code_digest
from deploy.studies.harness.runners.batches import batches
from deploy.studies.harness.runners.cluster import Cluster
from deploy.studies.harness.runners.ctrl_c import heeded
from deploy.studies.harness.runners.progress import StudyProgress
from deploy.studies.harness.runners.run_log import RunLog
from deploy.studies.harness.runners.worker import FAILED, Job
from deploy.studies.harness.runners.worker_pool import WorkerPool
from deploy.studies.harness.study import Row, Study


@dataclass(frozen=True)
class Outcome:
    """Rows of the cells that have results; `complete` unless the study was stopped."""

    rows: list[Row]
    complete: bool
    executed: int  # runs of this call
    reused: int  # runs known from before


def execute(
    study: Study,
    transport: Transport,
    log: RunLog,
    *,
    jobs: int,
    scheduler: str | None = None,
    quiet: bool = True,
) -> Outcome:
    """Run what `log` does not know yet. Ctrl-C stops it; what is done is in the log and in the rows.

    Args:
        jobs: runs at the same time on this machine.
        scheduler: of the Dask cluster that does the runs instead.

    Raises:
        UsageError: there is no way to reach a cluster.
        ProcessError: a worker or a fleet was lost; the same call goes on from there.
    """
    runs = study.runs(transport, code_digest())
    results = {(run.cell, run.seed): log.known[run.key] for run in runs if run.key in log.known}
    left = [run for run in runs if run.key not in log.known]
    reused, complete = len(results), True
    try:
        if left:
            dealt = batches(study, left, jobs)
            pool = WorkerPool(min(jobs, len(dealt))) if scheduler is None else Cluster(scheduler)
            progress = StudyProgress(study.name, len(runs), reused, quiet)
            _execute(study, dealt, pool, results, log, progress)
    except KeyboardInterrupt:
        complete = False
    return Outcome(study.rows(results), complete, len(results) - reused, reused)


def _execute(
    study: Study,
    dealt: Sequence[Sequence[Job]],
    workers: WorkerPool | Cluster,
    results: dict[tuple[int, int], dict[str, Any]],
    log: RunLog,
    progress: StudyProgress,
) -> None:
    with progress, workers as pool, heeded() as heed:
        for run, result in pool.run(dealt):
            results[run.cell, run.seed] = result
            if result["verdict"] != FAILED:
                log.add(run.key, result)
            progress.count(study.cells[run.cell].name)
            heed()
