"""A run from start to verdict: in this process, or as a fleet of processes."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from deploy.run.execute import Extras, execute
from deploy.run.options import Mode, RunOptions, Transport, fresh_run_name
from deploy.run.result import complete
from deploy.telemetry.recording.reader import read as read_recording
from disknav.scenarios import Settings, Source, ready
from disknav.simulation import Simulation
from disknav.trajectory import Trajectory
from protocol.errors import UsageError
from protocol.keys import checked_run
from protocol.scenario.model import Scenario


@dataclass(frozen=True, eq=False)
class Run:
    """Result and trajectory of a run.

    Attributes:
        result: the object that `disknav run --json` writes; docs/reference/result.md lists its fields.
        recording: path of the recording, None without `record`.
    """

    scenario: Scenario
    result: Mapping[str, Any]
    trajectory: Trajectory
    recording: Path | None = None

    @property
    def verdict(self) -> str:
        """How the run ended: "arrived", "collision", "timeout", "deadlock", "interrupted" or "aborted"."""
        return str(self.result["verdict"])

    @property
    def arrived(self) -> bool:
        """Whether all robots arrived without contact."""
        return self.verdict == "arrived"


def run(
    scenario: Source,
    settings: Settings | None = None,
    *,
    seed: int | None = None,
    transport: Transport = "local",
    mode: Mode = "lockstep",
    record: str | Path | None = None,
    name: str | None = None,
    progress: bool = False,
) -> Run:
    """Run a scenario to its verdict.

    Args:
        scenario: a result of `load` or `build`; or a source for `load`, with `settings` and `seed`.
        transport: "local" for all robots in this process; "routed" or "mesh" for one process each.
        mode: "lockstep", or "realtime" for one tick per period of the wall clock.
        record: path of the recording to write (MCAP).
        name: name of the run; by default a fresh one.
        progress: whether to print a progress bar on standard error.

    The trajectory in lock-step is the same on every transport. Ctrl-C ends the run as "interrupted".

    Raises:
        ScenarioError, UsageError: as `load`; or `settings` or `seed` are given with a finished scenario.
        ProcessError, BusError: the fleet could not be started.
    """
    scenario = ready(scenario, settings, seed)
    if transport != "local" and scenario.control.law.startswith("__main__:"):
        raise UsageError(
            f"the processes of a fleet cannot import {scenario.control.law!r} from this script or notebook: "
            'put the class into a module, or name its file, control.law = "law.py:Class"'
        )
    options = RunOptions(transport, mode, run=fresh_run_name() if name is None else checked_run(name))
    if transport == "local" and mode == "lockstep" and record is None and not progress:
        simulation = Simulation(scenario, name=options.run)
        return Run(scenario, complete(simulation.finish(), options, []), simulation.trajectory)
    with ExitStack() as stack:
        folder = stack.enter_context(TemporaryDirectory(prefix="disknav-"))
        path = Path(folder) / "run.mcap" if record is None else Path(record)
        result = execute(scenario, options, Extras(record=path), quiet=not progress)
        trajectory = Trajectory.of(scenario, read_recording(path).truths)
    return Run(scenario, result, trajectory, None if record is None else path)
