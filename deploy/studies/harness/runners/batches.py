"""How the runs of a study are dealt out to its workers."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from math import ceil

from deploy.studies.harness.runners.worker import Job
from deploy.studies.harness.study import Run, Study

BATCH = (
    8  # runs: what is lost with a worker, or with Ctrl-C, is at most this; and a fleet is started for as many
)


def batches(study: Study, runs: Sequence[Run], jobs: int) -> list[list[Job]]:
    """Batches for `jobs` workers, in the order in which to begin them.

    On real processes runs with the same robots share a fleet. Each worker has equally many batches of them,
    each with runs from all over the study, which balances what easy and hard cells take.
    """
    dealt: list[list[Job]] = []
    keyed = [(_fleet(study, run), run) for run in runs]
    for fleet, group in groupby(sorted(keyed, key=lambda each: each[0]), lambda each: each[0]):
        transport, _robots, changes = fleet
        several = [(run, study.cells[run.cell].build) for _, run in group]
        if study.isolated or changes:
            dealt += [[job] for job in several]
        elif transport == "local":
            dealt += [several[n : n + BATCH] for n in range(0, len(several), BATCH)]
        else:
            count = jobs * ceil(len(several) / (jobs * BATCH))
            dealt += [several[n::count] for n in range(min(count, len(several)))]
    return dealt


def _fleet(study: Study, run: Run) -> tuple[str, tuple[int, ...], bool]:
    """What runs on the same processes have in common, and whether a run leaves other processes."""
    if run.transport == "local":
        return run.transport, (), False
    scenario = study.cells[run.cell].build(run.seed)
    changes = any(order.add is not None or order.remove is not None for order in scenario.orders)
    return run.transport, scenario.ids, changes
