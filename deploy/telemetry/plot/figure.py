"""The whole picture: workspaces beside what changes over time."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure

from deploy.telemetry.plot.curves import (
    delayed_sensing,
    draw_clearance,
    draw_heard_ages,
    draw_measurement_ages,
    draw_potential,
    faulty_link,
)
from deploy.telemetry.plot.style import HANDLERS, curves, disks
from deploy.telemetry.plot.workspace import draw_workspace
from deploy.telemetry.recording.reader import Recording

Panel = Callable[[Axes], None]
_SIDE = 3.9  # inches, a workspace at least
_LEGEND = 0.35  # inches
_COLUMN = 3.3  # inches, curves
_PANEL = 1.2  # inches, height of one curve


def figure(recordings: Sequence[Recording]) -> Figure:
    """One workspace a recording, and their curves over time in one column beside them."""
    panels = _panels(recordings)
    height = max(_SIDE + _LEGEND, _PANEL * len(panels))
    workspaces = (height - _LEGEND) * len(recordings)
    whole = Figure(figsize=(workspaces + _COLUMN, height), layout="constrained")
    left, right = whole.subfigures(1, 2, width_ratios=[workspaces, _COLUMN], squeeze=False)[0]
    for axes, recording in zip(left.subplots(1, len(recordings), squeeze=False)[0], recordings, strict=True):
        draw_workspace(axes, recording)
        axes.set_title(_title(recording), loc="left")
    column = right.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for axes, panel in zip(column, panels, strict=True):
        panel(axes)
    column[-1].set_xlabel("time, s")
    right.align_ylabels(column)
    _legends(left, column, recordings)
    return whole


def _panels(recordings: Sequence[Recording]) -> list[Panel]:
    panels: list[Panel] = [
        lambda axes: draw_clearance(axes, recordings),
        lambda axes: draw_potential(axes, recordings),
    ]
    if len(recordings) == 1:
        (recording,) = recordings
        if delayed_sensing(recording):
            panels.append(lambda axes: draw_measurement_ages(axes, recording))
        if faulty_link(recording):
            panels.append(lambda axes: draw_heard_ages(axes, recording))
    return panels


def _title(recording: Recording) -> str:
    verdict = "not finished" if recording.result is None else recording.result["verdict"]
    seconds = recording.truths.ticks[-1] * recording.scenario.time.step
    return f"{recording.scenario.name}: {verdict} after {seconds:.1f} s"


def _legends(left: SubFigure, column: Sequence[Axes], recordings: Sequence[Recording]) -> None:
    left.legend(handles=disks(), handler_map=HANDLERS, loc="outside lower center", ncols=4)
    if len(recordings) > 1:
        column[0].legend(handles=curves([recording.path.stem for recording in recordings]), loc="best")
