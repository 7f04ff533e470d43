"""One trial of endurance: a fleet that never rests, what is done to it, and what its processes hold on to."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

from deploy.run.fleet import Fleet
from deploy.run.interruption import undisturbed
from deploy.run.outcome.reports import Report
from deploy.studies.endurance.disturbances import CUT
from deploy.studies.endurance.observation import Observation
from deploy.studies.endurance.outcome import result
from deploy.studies.endurance.recovery import AGAIN
from deploy.studies.endurance.samples import Samples
from deploy.studies.endurance.trial import Trial
from deploy.studies.endurance.workload import workload

_SAMPLES = 240  # a trial, at least 0.25 s and at most 30 s apart
_SPEED = 0.05  # m/s; half a minute a run
_KEPT = ("run_number", "verdict", "reason", "ticks", "wall_time", "missed_commands", "collisions")


def endure(trial: Trial, tell: Callable[[float], None]) -> dict[str, Any]:
    """Keep the fleet moving for its minutes, and judge; the result in plain types.

    Raises:
        ProcessError, BusError: the fleet could not be started.
    """
    seconds = 60.0 * trial.minutes
    scenarios = workload(trial.robots, speed=_SPEED, seconds=None if trial.options.lockstep else seconds)
    samples = Samples(min(30.0, max(0.25, seconds / _SAMPLES)))
    with ExitStack() as stack:
        observation = Observation(trial, scenarios, stack)
        with Fleet(
            scenarios, trial.options, watch=observation.watch, digest=_digest, lead=observation.lead
        ) as fleet:
            observation.attach(fleet)

            def enough() -> bool:
                samples.take(observation.pids())
                elapsed = observation.follow()
                tell(elapsed / seconds)
                late = elapsed >= seconds + CUT + AGAIN  # for who was hit last to move again
                return elapsed >= seconds and (late or not observation.recovery.standing)

            reports = fleet.execute(enough)
            fleet.processes()
        with undisturbed():
            stack.close()
    return result(trial, reports, samples, scenarios[0].time.step, observation.recovery, observation.blows)


def _digest(report: Report) -> Report:
    """What is kept of each run: hundreds of whole reports would look like a leak."""
    return {name: report[name] for name in _KEPT}
