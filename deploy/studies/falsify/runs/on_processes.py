"""The same scenario on real processes, which must drive the trajectory that it has within one process."""

from __future__ import annotations

import time

from deploy.run.fleet import Fleet
from deploy.run.options import RunOptions, Transport
from deploy.studies.falsify.runs.violation import Violation, other_trajectory, raised, violations
from protocol.scenario.model import Scenario

PATIENCE = 120.0  # s of wall time for one run, start and end included


def on_processes(scenario: Scenario, transport: Transport, trajectory: str) -> list[Violation]:
    """What is wrong with a run on a fleet of its own.

    Args:
        scenario: k a number.
        transport: how the processes are connected.
        trajectory: digest of what they should drive.
    """
    deadline = time.monotonic() + PATIENCE
    try:
        with Fleet([scenario], RunOptions(transport)) as fleet:
            (report,) = fleet.execute(lambda: time.monotonic() > deadline)
    except Exception as error:  # noqa: BLE001  whatever it is, it is what is looked for
        return [raised(error)]
    if report["trajectory_sha256"] is None:
        return [Violation("aborted", f"{transport}: {report['reason']}")]
    found = violations(report)
    if report["verdict"] == "interrupted":
        found.append(Violation("endless", f"{transport}: has not ended within {PATIENCE:g} s"))
    elif report["trajectory_sha256"] != trajectory:
        found.append(other_trajectory("bus", trajectory, report["trajectory_sha256"], f"on {transport}"))
    return found
