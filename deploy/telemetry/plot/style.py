"""How pictures look: readable in print, by the colour-blind, and in grey."""

from __future__ import annotations

from typing import Any

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
