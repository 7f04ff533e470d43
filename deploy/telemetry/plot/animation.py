"""A run as a film: disks that move and the paths behind them."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter, PillowWriter
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle
from matplotlib.text import Text

from deploy.telemetry.plot.workspace import INK, MANY, colour, dash, frame
from deploy.telemetry.recording.reader import Recording
from deploy.telemetry.recording.replay import Participant, participants
from protocol.errors import UsageError

Progress = Callable[[float], None]
_RATE = 12  # pictures a second
_PAUSE = 12  # pictures of the last instant at the end
_INCHES = (4.4, 4.6)
_TAIL = 2.0  # s of path behind each disk of a large fleet, whose whole paths would hide the disks
_QUALITY = 50  # of a .webp, where the outlines of disks are still clean; half the bytes of the library's 80


class Format(NamedTuple):
    """Size and length of an animation."""

    width: int = 440  # pixels
    seconds: float = 10.0  # a longer run is shown faster


def animate(
    recording: Recording, target: Path, progress: Progress | None = None, form: Format = Format()
) -> None:
    """Write `target`, a .gif, .webp or (where ffmpeg is installed) .mp4, in real time or faster.

    Raises:
        UsageError: .mp4 without ffmpeg.
    """
    film = _Film(recording)
    steps = list(_steps(recording, form.seconds))
    writer = _writer(target)
    with writer.saving(film.figure, str(target), form.width / _INCHES[0]):
        for index, step in enumerate(steps):
            film.show(step)
            writer.grab_frame()
            if progress is not None:
                progress(index / len(steps))


def _writer(target: Path) -> AbstractMovieWriter:
    if target.suffix == ".gif":
        return PillowWriter(fps=_RATE)
    if target.suffix == ".webp":
        return _WebpWriter(fps=_RATE)
    if shutil.which("ffmpeg") is None:
        raise UsageError(f"{target}: needs ffmpeg, which is not installed; install it, or name a .gif")
    return FFMpegWriter(fps=_RATE, extra_args=["-pix_fmt", "yuv420p"])


class _WebpWriter(PillowWriter):
    def finish(self) -> None:
        first, *rest = self._frames  # type: ignore[attr-defined]  # which the stubs of matplotlib lack
        first.save(
            self.outfile, save_all=True, append_images=rest, duration=1000 // _RATE, loop=0, quality=_QUALITY
        )


def _steps(recording: Recording, longest: float) -> Iterator[int]:
    """Index of the recorded tick that each picture shows."""
    ticks = recording.truths.ticks
    seconds = ticks[-1] * recording.scenario.time.step
    count = int(min(max(2.0, seconds * _RATE), longest * _RATE))
    yield from np.linspace(0, len(ticks) - 1, count).round().astype(int).tolist()
    yield from [len(ticks) - 1] * _PAUSE


class _Film:
    """One figure whose parts are moved from picture to picture."""

    def __init__(self, recording: Recording) -> None:
        self.figure = Figure(figsize=_INCHES, layout="constrained")
        self._recording = recording
        self._axes = self.figure.subplots()
        self._things = frame(self._axes, recording)
        for text in self._axes.texts:
            text.remove()  # a film shows when they come and go
        for patch, _ in self._things:
            patch.set(fill=True, linestyle="-")
        self._title = self._axes.set_title("", loc="left", family="monospace")
        self._robots = participants(recording)
        self._parts = [self._robot(index, robot) for index, robot in enumerate(self._robots)]
        self.show(0)
        self.figure.draw_without_rendering()
        self.figure.set_layout_engine("none")  # lay out once, not again for every picture

    def _robot(self, index: int, robot: Participant) -> tuple[Circle, Line2D, Text]:
        (x, y), look = robot.known[0].tolist(), colour(index)
        disk = Circle((x, y), robot.radius, facecolor=look, alpha=0.6, linewidth=0, zorder=4)
        if robot.goal is not None:
            goal = Circle(robot.goal, robot.radius, fill=False, edgecolor=look, linewidth=1.2, zorder=3)
            self._axes.add_patch(goal)
        self._axes.add_patch(disk)
        (trail,) = self._axes.plot([], [], color=look, linestyle=dash(index), zorder=3)
        name = str(robot.robot) if len(self._robots) <= MANY else ""
        label = self._axes.text(x, y, name, ha="center", va="center", color=INK, weight="bold", zorder=5)
        return disk, trail, label

    def show(self, step: int) -> None:
        """Move everything to one recorded tick."""
        truths, scenario = self._recording.truths, self._recording.scenario
        oldest = max(0, step - round(_TAIL / scenario.time.step)) if len(self._robots) > MANY else 0
        for robot, (disk, trail, label) in zip(self._robots, self._parts, strict=True):
            path = robot.path[: step + 1]
            trail.set_data(*path[oldest:].T)
            is_there = not np.isnan(path[-1, 0])
            disk.set_visible(is_there)
            label.set_visible(is_there)
            if is_there:
                disk.set_center(path[-1])
                label.set_position(path[-1])
        seconds = float(truths.ticks[step]) * scenario.time.step
        for patch, stay in self._things:
            patch.set_visible(stay.since <= seconds < stay.until)
        gap = 1000.0 * float(truths.clearance[step])
        self._title.set_text(f"{scenario.name}  t = {seconds:4.1f} s  clearance {gap:5.1f} mm")
