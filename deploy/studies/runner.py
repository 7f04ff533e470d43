"""Executes a study: what is not done yet, on all cores, with progress, and every result kept at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from deploy.options import Transport
from deploy.studies.batches import batches
from deploy.studies.crew import Crew
from deploy.studies.progress import StudyProgress
from deploy.studies.provenance import code_digest
from deploy.studies.run_log import RunLog
from deploy.studies.study import Row, Run, Study
from deploy.studies.worker import FAILED


@dataclass(frozen=True)
class Outcome:
    """Rows of the cells that have results; `complete` unless the study was stopped."""

    rows: list[Row]
    complete: bool
    executed: int  # runs of this call
    reused: int  # runs known from before


def execute(study: Study, transport: Transport, log: RunLog, *, jobs: int, quiet: bool = True) -> Outcome:
    """Run what `log` does not know yet. Ctrl-C stops it; what is done is in the log and in the rows.

    Raises:
        ProcessError: a worker or a fleet was lost; the same call goes on from there.
    """
    runs = study.runs(transport, code_digest())
    results = {(run.cell, run.seed): log.known[run.key] for run in runs if run.key in log.known}
    left = [run for run in runs if run.key not in log.known]
    reused, complete = len(results), True
    try:
        _execute(study, left, results, log, jobs=jobs, progress=StudyProgress(study.name, runs, left, quiet))
    except KeyboardInterrupt:
        complete = False
    return Outcome(study.rows(results), complete, len(results) - reused, reused)


def _execute(
    study: Study,
    left: Sequence[Run],
    results: dict[tuple[int, int], dict[str, Any]],
    log: RunLog,
    *,
    jobs: int,
    progress: StudyProgress,
) -> None:
    if not left:
        return
    dealt = batches(study, left, jobs)
    with progress, Crew(min(jobs, len(dealt))) as crew:
        for run, result in crew.run(dealt):
            results[run.cell, run.seed] = result
            if result["verdict"] != FAILED:
                log.add(run.key, result)
            progress.advance(study.cells[run.cell].name)
