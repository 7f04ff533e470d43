"""`disknav info`: what a recording holds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from rich.console import Console, Group
from rich.table import Table
from rich.text import Text

from deploy.commands import options
from deploy.output import json_output
from deploy.output.bar import bar
from protocol.errors import RecordingError

if TYPE_CHECKING:  # the rest of the command line does without what reading takes, numpy first of all
    from deploy.telemetry.recording.reading.reader import Recording


def info(
    recording: options.RecordingFile,
    json_file: options.Json = None,
) -> None:
    """Say what a recording holds: scenario, verdict, streams, and whether its trajectory is the result's.

    Example: disknav info figure-1.mcap
    """
    from deploy.telemetry.recording.reading.reader import read

    json_output.check(json_file)
    with bar(f"reading {recording.name}") as progress:
        found = read(recording, progress)
    summary = _summary(found)
    json_output.write_json({**summary, "streams": dict(found.counts), "result": found.result}, json_file)
    if not json_output.is_standard_output(json_file):
        Console().print(Group(_grid(summary), _streams(found)))


def _summary(recording: Recording) -> dict[str, str]:
    scenario, result = recording.scenario, recording.result or {}
    ticks = int(recording.truths.ticks[-1])
    return {
        "scenario": f"{scenario.name}, {len(scenario.robots)} robots, seed {scenario.seed}",
        "run": recording.run,
        "verdict": f"{result['verdict']}  {result.get('reason', '')}"
        if result
        else "none: no result was recorded",
        "ticks": f"{ticks}, {ticks * scenario.time.step:g} s simulated",
        "messages": f"{recording.counts.total()}",
        "file": "cut short: what follows the cut is lost" if recording.cut else "complete",
        "trajectory": _check(recording),
    }


def _grid(rows: Mapping[str, str]) -> Table:
    grid = Table.grid(padding=(0, 3))
    for name, value in rows.items():
        grid.add_row(Text(name, style="dim"), Text(value))
    return grid


def _check(recording: Recording) -> str:
    from deploy.telemetry.recording.reading.trajectory import trajectory

    try:
        found = trajectory(recording)
    except RecordingError as error:
        return f"cannot be checked: {error}"
    if recording.result is None:
        return f"{found.sha256}, nothing to compare it with{found.remark}"
    same = found.sha256 == recording.result.get("trajectory_sha256")
    return f"{found.sha256}, {'as in the result' if same else 'NOT the one in the result'}{found.remark}"


def _streams(recording: Recording) -> Table:
    table = Table(box=None, padding=(0, 2), header_style="dim")
    table.add_column("key")
    table.add_column("messages", justify="right")
    table.add_column("per tick", justify="right")
    ticks = max(1, int(recording.truths.ticks[-1]))
    for key, count in sorted(recording.counts.items()):
        table.add_row(key, str(count), f"{count / ticks:.2f}")
    return table
