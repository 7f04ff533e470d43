"""The workspace of one recording, and a style that is readable in print, in grey and for the colour-blind."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.legend_handler import HandlerPatch
from matplotlib.patches import Circle, Patch, Polygon
from matplotlib.patheffects import withStroke

from deploy.telemetry.recording.reader import Recording
from deploy.telemetry.recording.replay import participants
from protocol.geometry import Disk, Shape
from protocol.messages import Clock

# Okabe and Ito's palette without yellow and black, which vanish on paper and among text.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
DASHES: tuple[Any, ...] = ("-", "--", "-.", ":")
INK = "#222222"
FAINT = "#8a8a8a"

RC: Any = {
    "font.family": "sans-serif",
    "font.size": 8,
    "axes.titlesize": 9,
    "axes.labelsize": 8,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "legend.fontsize": 7,
    "axes.edgecolor": INK,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e3e3e3",
    "grid.linewidth": 0.5,
    "axes.axisbelow": True,
    "lines.linewidth": 1.2,
    "lines.solid_capstyle": "round",
    "legend.frameon": False,
    "savefig.dpi": 200,
    "pdf.fonttype": 42,  # text stays text
    "svg.fonttype": "none",
    "svg.hashsalt": "disknav",  # reproducible files
}


def colour(index: int) -> str:
    """Colour of the robot with this index."""
    return COLOURS[index % len(COLOURS)]


def dash(index: int) -> Any:
    """Line style of the same index, which tells repeated colours apart."""
    return DASHES[(index + index // len(COLOURS)) % len(DASHES)]


def _legend_disk(*, xdescent: float, ydescent: float, width: float, height: float, **_: object) -> Circle:
    return Circle((width / 2 - xdescent, height / 2 - ydescent), 0.75 * height)


HANDLERS = {Patch: HandlerPatch(patch_func=_legend_disk)}


def disks() -> list[Patch]:
    """Legend handles for the disks of a workspace."""
    return [
        Patch(fill=False, edgecolor=FAINT, linestyle=":", linewidth=1.0, label="start"),
        Patch(facecolor=FAINT, alpha=0.25, linewidth=0, label="between"),
        Patch(facecolor=FAINT, alpha=0.7, linewidth=0, label="end"),
        Patch(fill=False, edgecolor=FAINT, linewidth=1.2, label="goal"),
    ]


class Stay(NamedTuple):
    """An obstacle, from when until when it is present, s of simulated time; infinite if it stays."""

    shape: Shape
    since: float
    until: float

    @property
    def words(self) -> str:
        """Text with these times; "" for an obstacle that is always present."""
        came = f"from {self.since:.1f} s" if self.since > 0.0 else ""
        went = f"until {self.until:.1f} s" if math.isfinite(self.until) else ""
        return " ".join(filter(None, (came, went)))


def stays(recording: Recording) -> list[Stay]:
    """All obstacles of the run, by number, as the world's Clock reports them."""
    in_scenario = recording.scenario.shapes
    found = {number: Stay(shape, 0.0, math.inf) for number, shape in in_scenario.items()}
    for clock in recording.messages(Clock):
        listed = {obstacle.number: obstacle for obstacle in clock.obstacles}
        for number, obstacle in listed.items():
            if obstacle.status == "standing" and number not in found:
                found[number] = Stay(obstacle.shape, clock.time, math.inf)
        for number, stay in found.items():
            gone = listed[number].status == "gone" if number in listed else number not in in_scenario
            if gone:
                found[number] = stay._replace(until=min(stay.until, clock.time))
    return [found[number] for number in sorted(found)]


def draw_obstacles(axes: Axes, recording: Recording) -> list[tuple[Patch, Stay]]:
    """Draw all obstacles of the run: filled if present at the end, dashed if removed."""
    drawn = []
    for stay in stays(recording):
        went = math.isfinite(stay.until)
        patch = patch_of(stay.shape, facecolor=FAINT, edgecolor=INK, alpha=0.35, linewidth=0.8, zorder=3)
        if went:
            patch.set(fill=False, linestyle="--")
        axes.add_patch(patch)
        drawn.append((patch, stay))
        if stay.words:
            centre = stay.shape.around
            axes.text(
                centre.x, centre.y, stay.words, ha="center", va="center", fontsize=5, color=INK, zorder=6
            )
    return drawn


def patch_of(shape: Shape, **look: object) -> Patch:
    if isinstance(shape, Disk):
        return Circle((shape.x, shape.y), shape.radius, **look)
    return Polygon(shape.points, closed=True, **look)


_MOMENTS = 5  # disks drawn between start and end
MANY = 20  # largest number of robots drawn with ids


def draw_workspace(axes: Axes, recording: Recording) -> None:
    """Draw one run: dotted disks at the starts, outlined goals, filled disks at the ends."""
    frame(axes, recording)
    robots = participants(recording)
    ends = np.array([each.known[-1] for each in robots])
    for index, each in enumerate(robots):
        radius, path = each.radius, each.known
        axes.plot(*each.path.T, color=colour(index), linestyle=dash(index), linewidth=1.1, zorder=5)
        for moment in _moments(path, radius):
            _disk(axes, moment, radius, facecolor=colour(index), alpha=0.13, linewidth=0)
        _disk(axes, path[0], radius, fill=False, edgecolor=colour(index), linestyle=":", linewidth=1.0)
        _disk(axes, path[-1], radius, facecolor=colour(index), alpha=0.45, linewidth=0)
        if each.goal is not None:
            _disk(axes, each.goal, radius, fill=False, edgecolor=colour(index), linewidth=1.2)
        if len(robots) <= MANY:
            _label(axes, path[-1], str(each.robot))
            if _free(path[0], radius, ends):
                _label(axes, path[0], str(each.robot), faint=True)


def frame(axes: Axes, recording: Recording) -> list[tuple[Patch, Stay]]:
    """Draw boundary, obstacles, equal scales and axes (m); returns the artists of the obstacles."""
    room = recording.scenario.workspace.shape
    obstacles = draw_obstacles(axes, recording)
    axes.add_patch(patch_of(room, fill=False, edgecolor=INK, linewidth=1.2, zorder=2))
    (left, low), (right, high) = room.box
    margin = 0.02 * max(right - left, high - low)
    axes.set(
        xlim=(left - margin, right + margin),
        ylim=(low - margin, high + margin),
        aspect="equal",
        anchor="N",
        xlabel="x, m",
        ylabel="y, m",
    )
    axes.grid(visible=False)
    return obstacles


def _free(place: np.ndarray, radius: float, others: np.ndarray) -> bool:
    """Whether no disk ended at this start, so that a label is readable there."""
    return bool(np.all(np.hypot(*(others - place).T) > 0.6 * radius))


def _moments(path: np.ndarray, radius: float) -> np.ndarray:
    """Points at equal distances along a path, without its ends; fewer on a short path."""
    lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    count = min(_MOMENTS, int(lengths[-1] / (1.5 * radius)))
    marks = np.linspace(0.0, lengths[-1], count + 2)[1:-1]
    return path[np.searchsorted(lengths, marks)]


def _disk(axes: Axes, centre: np.ndarray | tuple[float, float], radius: float, **look: object) -> None:
    axes.add_patch(Circle((float(centre[0]), float(centre[1])), radius, zorder=4, **look))


def _label(axes: Axes, place: np.ndarray, text: str, *, faint: bool = False) -> None:
    axes.text(
        float(place[0]),
        float(place[1]),
        text,
        ha="center",
        va="center",
        fontsize=6.5 if faint else 7.5,
        color=FAINT if faint else INK,
        fontweight="normal" if faint else "bold",
        zorder=6,
        path_effects=[withStroke(linewidth=2.0, foreground="white")] if faint else None,
    )
