"""How pictures look, and what their marks mean: readable in print, by the colour-blind, and in grey."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.legend_handler import HandlerPatch
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch

# Okabe and Ito's palette without its yellow and black, which are lost on paper and among text.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
DASHES: tuple[Any, ...] = ("-", "--", "-.", ":")
MARKERS = ("o", "s", "^", "D", "v", "P")
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
    "svg.hashsalt": "disknav",  # the same picture is the same file
}


def colour(index: int) -> str:
    """Colour of the robot or curve with this place in the order."""
    return COLOURS[index % len(COLOURS)]


def dash(index: int) -> Any:
    """Line style that goes with it: it changes where colours repeat, and tells them apart in grey."""
    return DASHES[(index + index // len(COLOURS)) % len(DASHES)]


def marker(index: int) -> str:
    """Marker that goes with it."""
    return MARKERS[index % len(MARKERS)]


def _disk(*, xdescent: float, ydescent: float, width: float, height: float, **_: object) -> Circle:
    """A disk as a disk, where legends would show a box."""
    return Circle((width / 2 - xdescent, height / 2 - ydescent), 0.75 * height)


HANDLERS = {Patch: HandlerPatch(patch_func=_disk)}


def disks() -> list[Patch]:
    """Handles for the disks of a workspace."""
    return [
        Patch(fill=False, edgecolor=FAINT, linestyle=":", linewidth=1.0, label="start"),
        Patch(facecolor=FAINT, alpha=0.25, linewidth=0, label="between"),
        Patch(facecolor=FAINT, alpha=0.7, linewidth=0, label="end"),
        Patch(fill=False, edgecolor=FAINT, linewidth=1.2, label="goal"),
    ]


def curves(names: Sequence[str]) -> list[Line2D]:
    """Handles for curves in their order."""
    return [
        Line2D([], [], color=colour(index), linestyle=dash(index), label=name)
        for index, name in enumerate(names)
    ]
