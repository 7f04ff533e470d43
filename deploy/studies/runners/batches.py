"""How the runs of a study are dealt out to its workers."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

from deploy.studies.runners.worker import Job
from deploy.studies.study import Run, Study

_LOCAL = 8  # in-process runs a batch: little is lost by waiting for the last


def batches(study: Study, runs: Sequence[Run], jobs: int) -> list[list[Job]]:
    """Batches for `jobs` workers, in the order in which to begin them.

    On real processes runs with the same robots share a fleet, so there are as many batches of them as
    jobs, each with every `jobs`-th run, which balances what easy and hard cells take.
    """
    dealt: list[list[Job]] = []
    keyed = [(_fleet(study, run), run) for run in runs]
    for (transport, _robots), group in groupby(sorted(keyed, key=lambda each: each[0]), lambda each: each[0]):
        several = [(run, study.cells[run.cell].build) for _, run in group]
        if study.isolated:
            dealt += [[job] for job in several]
        elif transport == "local":
            dealt += [several[n : n + _LOCAL] for n in range(0, len(several), _LOCAL)]
        else:
            dealt += [several[n::jobs] for n in range(min(jobs, len(several)))]
    return dealt


def _fleet(study: Study, run: Run) -> tuple[str, tuple[int, ...]]:
    """What runs on the same processes have in common."""
    if run.transport == "local":
        return run.transport, ()
    return run.transport, study.cells[run.cell].build(run.seed).ids
