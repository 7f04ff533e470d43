"""The report of a run whose world is gone: what the launcher last heard, no judgement."""

from __future__ import annotations

from typing import Any

from protocol.messages import Clock
from protocol.scenario.model import Scenario
from world.world import World

_UNKNOWN = ("min_clearance", "nrl", "trajectory_sha256", "positions")
_PER_ROBOT = ("path_lengths", "lateral_deviation")


INTERRUPTED = "stopped by the user"  # reason of a run that Ctrl-C ended


def interrupted(report: dict[str, Any]) -> dict[str, Any]:
    """The same, of a run that Ctrl-C ended."""
    return {**report, "verdict": "interrupted", "reason": INTERRUPTED}


def unjudged(scenario: Scenario, last: Clock | None, wall_time: float) -> dict[str, Any]:
    """A readable report as of the last Clock heard; what is unknown is None.

    Args:
        scenario: of the run.
        last: newest Clock that the launcher heard, if any.
        wall_time: s since the fleet was started.
    """
    report = World(scenario).report()
    report.update(dict.fromkeys(_UNKNOWN))
    report.update({name: {} for name in _PER_ROBOT})
    report.update(messages={"published": 0, "received": 0, "rejected": {}}, wall_time=wall_time)
    if last is not None:
        report.update(run_number=last.run_number, ticks=last.tick, sim_time=last.time)
        report["phi"]["last"] = last.phi
    return report
