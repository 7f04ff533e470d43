"""Pictures of studies, drawn of their rows: what they share, and one of each but the peers'."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter, LogLocator, MaxNLocator, NullLocator

from deploy.studies.study import Row
from deploy.telemetry.plot.workspace import FAINT, INK, RC, colour, dash, marker

Chart = Callable[[Sequence[Row]], Figure]
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


_SCALE = {
    "nrl_mean": "nrl",
    "ticks_per_second": "ticks per second",
    "cpu_per_robot_tick_us": "CPU per robot and tick, µs",
    "memory_mb": "memory, MB",
}


def draw_study(chart: Chart, rows: Sequence[Row], target: Path) -> None:
    """Draw the rows of a study into `target`."""
    with mpl.rc_context(RC):
        metadata = {"Date": None} if target.suffix == ".svg" else {}
        chart(rows).savefig(target, metadata=metadata)


def _tightness(rows: Sequence[Row]) -> Figure:
    return _paper(rows, "tight")[0]


def _tuning(rows: Sequence[Row]) -> Figure:
    figure, axes = _paper(rows, "k")
    axes.set_xscale("log")
    plain_numbers(axes.xaxis)
    return figure


def _paper(rows: Sequence[Row], axis: str) -> tuple[Figure, Axes]:
    """Mean and deviation as measured, the paper's printed values, and the exact flow's."""
    figure, ((axes,),) = panels(1, 1, 3.6)
    points = [(row[axis], row["nrl_mean"], row["nrl_std"]) for row in rows]
    Curve("measured, mean and deviation", points, 0, 0).draw(axes)
    for name, look, words in (
        ("paper", {"marker": "s", "color": INK, "markerfacecolor": HOLLOW}, "printed in the paper"),
        ("exact", {"marker": "x", "color": colour(1)}, "exact flow"),
    ):
        known = [(row[axis], row[name]) for row in rows if row[name] is not None]
        axes.plot(
            [x for x, _ in known],
            [y for _, y in known],
            linestyle="",
            markersize=6,
            zorder=2.5,
            label=words,
            **look,
        )
    axes.set(xlabel=axis, ylabel="normalised path length")
    heading(figure, f"{runs(rows)} a point, from random starts; of those that arrived")
    legend(figure)
    return figure, axes


def _scale(rows: Sequence[Row]) -> Figure:
    """What grows with the number of robots: a curve for every transport."""
    figure, grid = panels(2, 2, 2.6, sharex=True)
    transports = dict.fromkeys(row["transport"] for row in rows)
    counts = sorted({row["robots"] for row in rows})
    for axes, (name, words) in zip(grid.flat, _SCALE.items(), strict=True):
        axes.set_xscale("log")
        for place, transport in enumerate(transports):
            points: list[tuple[Any, ...]] = [
                (row["robots"], row[name]) for row in rows if row["transport"] == transport
            ]
            Curve(transport, points, place, place, hollow=place > 0).draw(axes)
        if name != "nrl_mean":
            axes.set_yscale("log")
            plain_numbers(axes.yaxis)
        axes.set_ylabel(words)
        axes.set_xticks(counts, map(str, counts))
        axes.xaxis.set_minor_locator(NullLocator())
    for axes in grid[-1]:
        axes.set_xlabel("robots")
    heading(figure, f"mean of {runs(rows)} a point; nrl of those that arrived")
    legend(figure)
    return figure


def _arrival(rows: Sequence[Row]) -> Figure:
    """Which share of those whose goals leave room had arrived by when."""
    figure, ((axes,),) = panels(1, 1, 3.6)
    for n, row in enumerate(rows):
        times = row["times"]
        axes.step(
            [0.0, *times],
            [100.0 * came / max(1, row["room"]) for came in range(len(times) + 1)],
            where="post",
            color=colour(n),
            label=f"noise {1e3 * row['noise']:g} mm, density {row['density']:g}",
        )
    axes.set(xlabel="time, s", ylabel="arrived, %", ylim=(0.0, 101.0))
    heading(figure, f"{runs(rows)} a curve; of those whose goals leave room for the error sets")
    legend(figure)
    return figure


_AXIS = "one-way delay, s"
_FILTERS = {"separating-lines": "separating lines", "none": "bare law"}
_SHARES = {"arrived": "runs that arrived, %", "collisions": "runs that touched, %"}
_TIME = "time of arrival, s"


def robustness(rows: Sequence[Row]) -> Figure:
    """Arrivals, collisions and time, a column for every loss; noise and period as they mostly are."""
    shown = [row for row in rows if row["noise"] == 0.0 and row["period"] == 0.05]
    losses = sorted({row["loss"] for row in shown})
    figure, grid = panels(3, len(losses), 1.9, sharex=True, sharey="row")
    for column, loss in zip(grid.T, losses, strict=True):
        own = [row for row in shown if row["loss"] == loss]
        for axes, name in zip(column, (*_SHARES, "time"), strict=True):
            for curve in _of_filters(own, name):
                curve.draw(axes)
        column[0].set_title(f"{100.0 * loss:g} % lost")
        column[-1].set_xlabel(_AXIS)
        column[-1].xaxis.set_major_locator(MaxNLocator(4, steps=(1, 2, 5, 10)))
        column[-1].xaxis.set_major_formatter(FormatStrFormatter("%g"))
    for axes, words in zip(grid[:, 0], (*_SHARES.values(), _TIME), strict=True):
        axes.set_ylabel(words)
    for axes in grid[:2].flat:
        axes.set_ylim(-7.0, 107.0)
    heading(
        figure,
        f"{runs(shown)} a point, from the same starts; no noise, period 50 ms",
        "time: mean of the runs that arrived, no mark where none did",
    )
    legend(figure)
    return figure


def _of_filters(rows: Sequence[Row], name: str) -> list[Curve]:
    curves = []
    for place, (filter_, words) in enumerate(_FILTERS.items()):
        points = [
            (row["delay"], row["time_mean"] if name == "time" else 100.0 * row[name] / row["runs"])
            for row in rows
            if row["filter"] == filter_
        ]
        curves.append(Curve(words, points, place, place, hollow=place > 0))
    return curves


def delay(rows: Sequence[Row]) -> Figure:
    """Time over the delay, and against the same runs without: a colour a scenario, a line style a pace."""
    figure, ((times, ratios),) = panels(1, 2, 3.4)
    scenarios = list(dict.fromkeys(row["scenario"] for row in rows))
    paces = list(dict.fromkeys(row["pace"] for row in rows))
    for place, scenario in enumerate(scenarios):
        for style, pace in enumerate(paces):
            own = [row for row in rows if (row["scenario"], row["pace"]) == (scenario, pace)]
            label, hollow = f"{scenario}, {pace} pace", style > 0
            time = [(row["delay"], row["time_mean"]) for row in own]
            ratio = [(row["delay"], row["ratio"], row["ratio_error"]) for row in own]
            Curve(label, time, place, style, hollow).draw(times)
            Curve(label, ratio, place, style, hollow).draw(ratios)
    times.set(xlabel=_AXIS, ylabel=_TIME)
    times.set_ylim(bottom=0.0)
    ratios.axhline(1.0, color=FAINT, linewidth=0.6, zorder=1)
    ratios.set(xlabel=_AXIS, ylabel="time against no delay")
    heading(
        figure,
        f"{runs(rows)} a point, from the same starts; of those that arrived; standard error of the ratio",
    )
    legend(figure)
    return figure


CHARTS: dict[str, Chart] = {
    "tightness": _tightness,
    "tuning": _tuning,
    "robustness": robustness,
    "arrival": _arrival,
    "delay": delay,
    "scale": _scale,
}
