"""What pictures of studies share: panels, curves, words above all panels, marks explained below them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter, LogLocator, MaxNLocator, NullLocator

from deploy.studies.study import Row
from deploy.telemetry.plot.workspace import colour, dash, marker

WIDTH = 7.2  # inches, what an A4 page has room for
HOLLOW = "white"
_NARROW = 6.0  # upper over lower end


@dataclass(frozen=True)
class Curve:
    """Points (x, y) or (x, y, error) under one label; those whose y is None are left out.

    place: in the order of colours and markers; style: in the order of line styles.
    hollow: with larger, empty markers, so that another curve over the same points leaves both to be seen.
    """

    label: str
    points: Sequence[tuple[Any, ...]]
    place: int
    style: int
    hollow: bool = False

    def draw(self, axes: Axes) -> None:
        """Draw the points, lines between them, and errors where they have any."""
        known = [point for point in self.points if point[1] is not None]
        errors = [point[2] or 0.0 for point in known if len(point) > 2]
        axes.errorbar(
            [point[0] for point in known],
            [point[1] for point in known],
            errors or None,
            color=colour(self.place),
            linestyle=dash(self.style),
            marker=marker(self.place),
            markersize=5.5 if self.hollow else 3.5,
            markerfacecolor=HOLLOW if self.hollow else None,
            zorder=2.0 if self.hollow else 2.1,
            capsize=2.5,
            label=self.label,
        )


def panels(rows: int, columns: int, height: float, **shared: Any) -> tuple[Figure, Any]:
    """An empty picture as wide as a page, `height` inches a row, and its axes (rows, columns)."""
    figure = Figure(figsize=(WIDTH, height * rows), layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False, **shared)


def heading(figure: Figure, *lines: str) -> None:
    """Lines above all panels."""
    figure.suptitle("\n".join(lines), x=0.01, ha="left", fontsize=8)


def legend(figure: Figure, marks: Mapping[str, Any] | None = None, columns: int = 4) -> None:
    """What the marks mean, below all panels: handles by label; the first panel's curves, unless given."""
    if marks is None:
        handles, labels = figure.axes[0].get_legend_handles_labels()
        marks = dict(zip(labels, handles, strict=True))
    figure.legend(list(marks.values()), list(marks), loc="outside lower center", ncols=columns)


def plain_numbers(axis: Axis, steps: Sequence[float] = (1.0, 2.0, 5.0)) -> None:
    """Ticks of a logarithmic axis, to be set after its data, written out: these multiples of powers of ten.

    Where hardly one of those would be seen, even steps as on a linear axis.
    """
    low, high = axis.get_view_interval()
    narrow = high < _NARROW * low
    axis.set_major_locator(MaxNLocator(5) if narrow else LogLocator(subs=steps))
    axis.set_major_formatter(FormatStrFormatter("%g"))
    axis.set_minor_locator(NullLocator())


def runs(rows: Sequence[Row]) -> str:
    """How many runs a row stands for, in words."""
    few, most = min(row["runs"] for row in rows), max(row["runs"] for row in rows)
    return f"{'' if few == most else f'{few} to '}{most} run{'' if most == 1 else 's'}"
