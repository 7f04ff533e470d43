"""Figures of recordings: workspaces beside clearance, potential and ages over time; and animations."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from itertools import groupby
from operator import attrgetter
from pathlib import Path

import numpy as np
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter, PillowWriter
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle
from matplotlib.text import Text

from agents.peers.link import StateLink
from agents.peers.state import addressed_to
from deploy.telemetry.plot.workspace import (
    HANDLERS,
    INK,
    MANY,
    colour,
    dash,
    disks,
    draw_workspace,
    frame,
)
from deploy.telemetry.recording.reader import Progress, Recording
from deploy.telemetry.recording.replay import Participant, participants
from protocol.errors import UsageError
from protocol.messages import State, Tick
from protocol.scenario.network import Link as LinkFaults


def measurement_ages(recording: Recording) -> tuple[np.ndarray, np.ndarray]:
    """Ticks, and (tick, robot) the age (s) of the newest own measurement; NaN if none."""
    ids, ticks = recording.scenario.ids, recording.trajectory.ticks
    ages = np.full((len(ticks), len(ids)), np.nan)
    row = {int(tick): index for index, tick in enumerate(ticks)}
    newest = dict.fromkeys(ids, -1)
    for tick in recording.messages(Tick):
        robot, sense = tick.robot, tick.sense
        if robot not in newest:
            continue
        if sense is not None and sense.position is not None:
            newest[robot] = max(newest[robot], sense.stamp)
        if newest[robot] >= 0 and tick.tick in row:
            ages[row[tick.tick], ids.index(robot)] = tick.tick - newest[robot]
    return ticks, ages * recording.scenario.time.step


def state_ages(recording: Recording) -> tuple[np.ndarray, np.ndarray, float]:
    """Ticks; (tick, robot) the age (s) of the oldest among the peers' newest States, NaN if none; and the
    share of States lost by the link.

    What each robot of the scenario received is computed from the recorded States and the same random link
    faults: exact in lock-step; in real time without the delay of the network.
    """
    ids, sent = recording.scenario.ids, 0
    radii = {spec.id: spec.radius for spec in recording.scenario.robots}
    links = {robot: StateLink(recording.scenario, robot) for robot in ids}
    newest: dict[int, dict[int, int]] = {robot: {} for robot in ids}
    ticks, rows = [], []
    for tick, states in groupby(recording.messages(State), attrgetter("tick")):
        found = [state for state in states if state.robot in newest]
        places = {state.robot: state.position for state in found}
        for robot, link in links.items():
            link.locate(tick, places.get(robot))
            for state in found:
                if state.robot != robot:
                    link.put(addressed_to(robot, state, radii[state.robot]))
                    sent += 1
            for heard in link.take(tick):
                newest[robot][heard.robot] = max(heard.tick, newest[robot].get(heard.robot, -1))
        ticks.append(tick)
        rows.append([tick - min(newest[robot].values(), default=np.nan) for robot in ids])
    ages = np.array(rows, dtype=float) * recording.scenario.time.step
    return np.array(ticks), ages, sum(link.lost for link in links.values()) / max(1, sent)


_COLUMNS = 2000  # of ages; more than pixels
_INFINITE = 300.0  # bound of `Truth.log_potential`


def draw_clearance(axes: Axes, recording: Recording) -> None:
    """Smallest gap between two disks, or disk and boundary, during each tick."""
    _curve(axes, recording, 1000.0 * recording.trajectory.clearance)
    axes.axhline(0.0, color=INK, linewidth=0.8)
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, -0.04 * high), high)
    axes.axhspan(axes.get_ylim()[0], 0.0, facecolor="none", edgecolor="#bbbbbb", hatch="////", linewidth=0)
    axes.set(ylabel="clearance, mm")


def draw_potential(axes: Axes, recording: Recording) -> None:
    """The potential, log10(gamma / beta^(1/k)); phi is 1 to all digits in a large fleet until the end."""
    levels = recording.trajectory.log_potential
    _curve(axes, recording, np.where(np.abs(levels) < _INFINITE, levels, np.nan))
    axes.set(ylabel="log$_{10}$(γ / β$^{1/k}$)")


def draw_measurement_ages(axes: Axes, recording: Recording) -> None:
    """Age of each robot's newest measurement of its own position."""
    _ages(axes, recording, *measurement_ages(recording))
    axes.set_title("age of own position", loc="left")


def draw_heard_ages(axes: Axes, recording: Recording) -> None:
    """Age of the oldest State among the newest of each robot's peers."""
    ticks, ages, lost = state_ages(recording)
    _ages(axes, recording, ticks, ages)
    axes.set_title(f"age of oldest peer state, {lost:.0%} lost", loc="left")


def _ages(axes: Axes, recording: Recording, ticks: np.ndarray, ages: np.ndarray) -> None:
    """One row per robot, darker for higher age, blank without information; a column is at least a pixel."""
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


def _curve(axes: Axes, recording: Recording, values: np.ndarray) -> None:
    axes.plot(recording.trajectory.times, values, color=colour(0))


Panel = Callable[[Axes, Recording], None]
_SIDE = 3.9  # inches, least side of a workspace
_LEGEND = 0.35  # inches
_COLUMN = 3.3  # inches, curves
_PANEL = 1.2  # inches, height of one curve


def figure(recording: Recording) -> Figure:
    """The workspace, and curves over time in a column beside it."""
    panels: list[Panel] = [draw_clearance, draw_potential]
    sensing = map(recording.scenario.sensing_of, recording.scenario.ids)
    if any(each.dropout > 0.0 or each.delay not in (0.0, (0.0, 0.0)) for each in sensing):
        panels.append(draw_measurement_ages)
    if recording.scenario.link != LinkFaults():
        panels.append(draw_heard_ages)
    height = max(_SIDE + _LEGEND, _PANEL * len(panels))
    width = height - _LEGEND
    whole = Figure(figsize=(width + _COLUMN, height), layout="constrained")
    left, right = whole.subfigures(1, 2, width_ratios=[width, _COLUMN], squeeze=False)[0]
    workspace = left.subplots()
    draw_workspace(workspace, recording)
    workspace.set_title(_title(recording), loc="left")
    left.legend(handles=disks(), handler_map=HANDLERS, loc="outside lower center", ncols=4)
    column = right.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for axes, panel in zip(column, panels, strict=True):
        panel(axes, recording)
    column[-1].set_xlabel("time, s")
    right.align_ylabels(column)
    return whole


def _title(recording: Recording) -> str:
    shown = "the first" if recording.result is None else f"{recording.result['verdict']} after"
    return f"{recording.scenario.name}: {shown} {recording.trajectory.times[-1]:.1f} s"


_RATE = 12  # frames per second
_PAUSE = 12  # copies of the last frame
_INCHES = (4.4, 4.6)
_WIDTH = 440  # pixels, unless given
_LONGEST = 10.0  # s, unless given; a longer run is shown faster
_TAIL = 2.0  # s of path behind each disk of a large fleet, where whole paths would hide the disks
_QUALITY = 50  # of a .webp: clean outlines, half the size of the default 80


def animate(
    recording: Recording,
    target: Path,
    progress: Progress,
    width: int | None = None,
    seconds: float | None = None,
) -> None:
    """Write `target`, a .gif, .webp or (with ffmpeg) .mp4, in real time or faster.
    Raises UsageError for an .mp4 without ffmpeg.
    """
    film = _Film(recording)
    steps = list(_steps(recording, seconds or _LONGEST))
    writer = _writer(target)
    with writer.saving(film.figure, str(target), (width or _WIDTH) / _INCHES[0]):
        for index, step in enumerate(steps):
            film.show(step)
            writer.grab_frame()
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
        first, *rest = self._frames  # type: ignore[attr-defined]  # missing in matplotlib's stubs
        first.save(
            self.outfile, save_all=True, append_images=rest, duration=1000 // _RATE, loop=0, quality=_QUALITY
        )


def _steps(recording: Recording, longest: float) -> Iterator[int]:
    times = recording.trajectory.times
    seconds = times[-1]
    count = int(min(max(2.0, seconds * _RATE), longest * _RATE))
    yield from np.linspace(0, len(times) - 1, count).round().astype(int).tolist()
    yield from [len(times) - 1] * _PAUSE


class _Film:
    """A figure whose artists are moved from frame to frame."""

    def __init__(self, recording: Recording) -> None:
        self.figure = Figure(figsize=_INCHES, layout="constrained")
        self._recording = recording
        self._axes = self.figure.subplots()
        self._obstacles = frame(self._axes, recording)
        for text in self._axes.texts:
            text.remove()  # times are visible in the animation
        for patch, _ in self._obstacles:
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
        """Move all artists to one recorded tick."""
        whole, scenario = self._recording.trajectory, self._recording.scenario
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
        seconds = float(whole.times[step])
        for patch, stay in self._obstacles:
            patch.set_visible(stay.since <= seconds < stay.until)
        gap = 1000.0 * float(whole.clearance[step])
        self._title.set_text(f"{scenario.name}  t = {seconds:4.1f} s  clearance {gap:5.1f} mm")
