"""A run as a film: disks that move and the paths behind them."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter, PillowWriter
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle
from matplotlib.text import Text

from deploy.plot.style import INK, colour, dash
from deploy.plot.workspace import MANY, frame
from deploy.recording.reader import Recording
from protocol.errors import UsageError

Progress = Callable[[float], None]
_RATE = 12  # pictures a second
_LONGEST = 120  # pictures; a longer run is shown faster
_PAUSE = 12  # pictures that the end stands still
_DPI = 100


def animate(recording: Recording, target: Path, progress: Progress | None = None) -> None:
    """Write `target`, a .gif or (where ffmpeg is installed) an .mp4, in real time or faster.

    Raises:
        UsageError: .mp4 without ffmpeg.
    """
    film = _Film(recording)
    steps = list(_steps(recording))
    writer = _writer(target)
    with writer.saving(film.figure, str(target), _DPI):
        for index, step in enumerate(steps):
            film.show(step)
            writer.grab_frame()
            if progress is not None:
                progress(index / len(steps))


def _writer(target: Path) -> AbstractMovieWriter:
    if target.suffix == ".gif":
        return PillowWriter(fps=_RATE)
    if shutil.which("ffmpeg") is None:
        raise UsageError(f"{target}: needs ffmpeg, which is not installed; install it, or name a .gif")
    return FFMpegWriter(fps=_RATE, extra_args=["-pix_fmt", "yuv420p"])


def _steps(recording: Recording) -> Iterator[int]:
    """Which recorded tick each picture shows."""
    ticks = recording.truths.ticks
    seconds = ticks[-1] * recording.scenario.time.step
    count = int(min(max(2.0, seconds * _RATE), _LONGEST))
    yield from np.linspace(0, len(ticks) - 1, count).round().astype(int).tolist()
    yield from [len(ticks) - 1] * _PAUSE


class _Film:
    """One figure whose parts are moved from picture to picture."""

    def __init__(self, recording: Recording) -> None:
        self.figure = Figure(figsize=(4.4, 4.6), layout="constrained")
        self._recording = recording
        self._axes = self.figure.subplots()
        self._things = frame(self._axes, recording)
        for text in self._axes.texts:
            text.remove()  # a film shows when they come and go
        for patch, _ in self._things:
            patch.set(fill=True, linestyle="-")
        self._title = self._axes.set_title("", loc="left", family="monospace")
        self._parts = [self._robot(index, robot) for index, robot in enumerate(recording.scenario.ids)]
        self.show(0)
        self.figure.draw_without_rendering()
        self.figure.set_layout_engine("none")  # lay out once, not again for every picture

    def _robot(self, index: int, robot: int) -> tuple[Circle, Line2D, Text]:
        spec = self._recording.scenario.spec(robot)
        look = colour(index)
        goal = Circle(spec.goal, spec.radius, fill=False, edgecolor=look, linewidth=1.2, zorder=3)
        disk = Circle(spec.start, spec.radius, facecolor=look, alpha=0.6, linewidth=0, zorder=4)
        self._axes.add_patch(goal)
        self._axes.add_patch(disk)
        (trail,) = self._axes.plot([], [], color=look, linestyle=dash(index), zorder=3)
        name = str(robot) if len(self._recording.scenario.ids) <= MANY else ""
        label = self._axes.text(
            *spec.start, name, ha="center", va="center", color=INK, weight="bold", zorder=5
        )
        return disk, trail, label

    def show(self, step: int) -> None:
        """Move everything to one recorded tick."""
        truths, scenario = self._recording.truths, self._recording.scenario
        for index, (disk, trail, label) in enumerate(self._parts):
            path = truths.positions[: step + 1, index]
            disk.set_center(path[-1])
            trail.set_data(*path.T)
            label.set_position(path[-1])
        seconds = float(truths.ticks[step]) * scenario.time.step
        for patch, stay in self._things:
            patch.set_visible(stay.since <= seconds < stay.until)
        gap = 1000.0 * float(truths.clearance[step])
        self._title.set_text(f"{scenario.name}  t = {seconds:4.1f} s  clearance {gap:5.1f} mm")
