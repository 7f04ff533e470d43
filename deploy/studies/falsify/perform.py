"""`disknav study falsify`, from what was asked for to table, files and exit status."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path

from rich.console import Console

from deploy.output.exit_status import EXIT_ARRIVED, EXIT_INTERRUPTED, EXIT_OTHERWISE
from deploy.output.json_output import check, is_standard_output, write_json
from deploy.software.provenance import code_digest, provenance
from deploy.studies.falsify.campaign import Campaign, Plan
from deploy.studies.falsify.files import Files
from deploy.studies.falsify.rows import done, listed, rows, table
from deploy.studies.falsify.scenarios.draw import drawn
from deploy.studies.falsify.trial import Trial, perform
from deploy.studies.harness.request import Request
from deploy.studies.harness.runners.cluster import Cluster
from deploy.studies.harness.runners.ctrl_c import heeded
from deploy.studies.harness.runners.progress import StudyProgress
from deploy.studies.harness.runners.run_log import RunLog
from deploy.studies.harness.runners.worker_pool import WorkerPool
from protocol.errors import UsageError

RUNS = 1000


def falsify(request: Request, log_path: Path | None) -> int:
    """Search for a violation; the exit status.

    Raises:
        UsageError, ScenarioError: what was asked for cannot be.
        ProcessError: the cluster or a worker was lost; the same request goes on from there.
    """
    plan = Plan(
        request.seed, request.runs or RUNS, request.transport or "local", request.settings, code_digest()
    )
    files = Files(request.found)
    _check(request, plan)
    quiet = request.quiet or is_standard_output(request.target)
    complete = False
    with RunLog(log_path, fresh=request.fresh) as log:
        campaign = Campaign(plan, log, files.keep)
        try:
            _execute(campaign, request, quiet)
            complete = True
        except KeyboardInterrupt:
            print("disknav: stopped; what was found is kept", file=sys.stderr)
    found, violations = rows(campaign), listed(campaign.findings, files)
    write_json(
        {
            "study": "falsify",
            "rows": found,
            "violations": violations,
            "provenance": provenance(plan.seed, plan.transport, request.jobs)
            | {"scheduler": request.scheduler, "settings": list(plan.settings), "complete": complete},
        },
        request.target,
    )
    if not quiet:
        Console(width=None if sys.stdout.isatty() else 160).print(table(found, violations))
        print(f"falsify: {len(campaign.findings)} violations in {done(campaign)} of {plan.runs} runs")
    if violations:
        return EXIT_OTHERWISE
    return EXIT_ARRIVED if complete else EXIT_INTERRUPTED


def _execute(campaign: Campaign, request: Request, quiet: bool) -> None:
    crew = (
        WorkerPool(request.jobs, perform)
        if request.scheduler is None
        else Cluster(request.scheduler, perform)
    )
    progress = StudyProgress("falsify", campaign.plan.runs, 0, quiet)
    with progress, crew as workers, heeded() as heed:

        def advance(said: str) -> None:
            progress.count(said)
            heed()

        campaign.execute(workers, advance)


def _check(request: Request, plan: Plan) -> None:
    """Find out before the runs what would fail after them."""
    check(request.target)
    if request.plot is not None or request.random is not None:
        raise UsageError(
            "study falsify has nothing to plot, and is random anyway: leave out --plot, --random"
        )
    Trial(partial(drawn, plan.seed), plan.settings).scenario(0)
