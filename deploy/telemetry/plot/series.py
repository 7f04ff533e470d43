"""What changes over time: clearance, phi, and the age of what robots know."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from deploy.telemetry.plot.ages import Heard, measurement_ages
from deploy.telemetry.plot.style import INK, colour, dash
from deploy.telemetry.plot.workspace import MANY
from deploy.telemetry.recording.reading.reader import Recording

_COLUMNS = 2000  # of ages, more than there are pixels


def draw_clearance(axes: Axes, recordings: Sequence[Recording]) -> None:
    """The smallest gap between any two disks, or disk and boundary, during each tick."""
    for index, recording in enumerate(recordings):
        _curve(axes, recording, 1000.0 * recording.truths.clearance, index, len(recordings))
    axes.axhline(0.0, color=INK, linewidth=0.8)
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, -0.04 * high), high)
    axes.axhspan(axes.get_ylim()[0], 0.0, facecolor="none", edgecolor="#bbbbbb", hatch="////", linewidth=0)
    axes.set(ylabel="clearance, mm")


def draw_phi(axes: Axes, recordings: Sequence[Recording]) -> None:
    """The navigation function: 1 on the boundary of free space, 0 at the goal."""
    for index, recording in enumerate(recordings):
        _curve(axes, recording, recording.truths.phi, index, len(recordings))
    axes.set(ylabel="φ", ylim=(-0.03, 1.03))


def draw_measurement_ages(axes: Axes, recording: Recording) -> None:
    """Age of the newest measurement of its own position that each robot had."""
    _ages(axes, recording, *measurement_ages(recording))
    axes.set_title("age of own position", loc="left")


def draw_heard_ages(axes: Axes, recording: Recording) -> None:
    """Age of what each robot had heard of that peer of which it knew the oldest."""
    heard = Heard(recording)
    _ages(axes, recording, *heard.ages())
    axes.set_title(f"age of oldest peer state, {heard.share_lost():.0%} lost", loc="left")


def _ages(axes: Axes, recording: Recording, ticks: np.ndarray, ages: np.ndarray) -> None:
    """A row a robot, darker is older, a column at least a pixel; nothing where nothing was known."""
    stride = -(-len(ticks) // _COLUMNS)
    ticks, ages = ticks[::stride], np.fmax.reduceat(ages, np.arange(0, len(ages), stride))
    edges = np.append(ticks, ticks[-1] + stride) * recording.scenario.time.step
    rows = np.arange(ages.shape[1] + 1)
    mesh = axes.pcolormesh(edges, rows, ages.T, cmap="cividis_r", vmin=0.0, rasterized=True)
    if ages.shape[1] <= MANY:
        axes.set_yticks(rows[:-1] + 0.5, [str(robot) for robot in recording.scenario.ids])
    axes.invert_yaxis()
    axes.grid(visible=False)
    axes.set_ylabel("robot")
    axes.figure.colorbar(mesh, ax=axes, label="s", pad=0.01, fraction=0.06)


def _curve(axes: Axes, recording: Recording, values: np.ndarray, index: int, of: int) -> None:
    times = recording.truths.ticks * recording.scenario.time.step
    axes.plot(times, values, color=colour(index), linestyle=dash(index) if of > 1 else "-")
