"""One scenario from launch to result, on any transport, with what was asked for on top."""

from __future__ import annotations

import tempfile
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from deploy.fleet import Fleet
from deploy.local import LocalFleet
from deploy.options import RunOptions
from deploy.progress import RunProgress
from deploy.result import Result, complete
from protocol.errors import UsageError
from protocol.scenario import Scenario


@dataclass(frozen=True)
class Extras:
    """What `disknav run` does besides running."""

    record: Path | None = None
    plot: Path | None = None
    web: bool = False


def execute(scenario: Scenario, options: RunOptions, extras: Extras, *, quiet: bool) -> Result:
    """Run `scenario` to its verdict.

    Raises:
        UsageError: the options do not fit together, or an optional library is missing.
        ProcessError, BusError: the fleet could not be started.
    """
    for target in (extras.record, extras.plot):
        if target is not None and not target.parent.is_dir():
            raise UsageError(f"{target}: the folder {target.parent} does not exist")
    with ExitStack() as stack:
        recording = _recording_path(extras, stack)
        with RunProgress(scenario, quiet) as progress:
            fleet = _fleet(scenario, options, recording, progress, extras.web)
            reports, processes = fleet.execute(), fleet.processes()
        result = complete(reports[0], options, processes)
        if recording is not None:
            from deploy.recording.result import attach

            attach(recording, result)
        if extras.plot is not None and recording is not None:
            from deploy.plot import draw

            draw(recording, extras.plot)
    return result


def _recording_path(extras: Extras, stack: ExitStack) -> Path | None:
    """Where to record: as asked, or somewhere for the picture's sake."""
    if extras.record is not None or extras.plot is None:
        return extras.record
    return Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="disknav-"))) / "run.mcap"


def _fleet(
    scenario: Scenario, options: RunOptions, recording: Path | None, progress: RunProgress, web: bool
) -> Fleet | LocalFleet:
    if options.transport == "local":
        return LocalFleet(
            [scenario], options.run, lockstep=options.lockstep, watch=progress.watch, record=recording
        )
    return Fleet([scenario], options, watch=progress.watch, record=recording, web=web)
