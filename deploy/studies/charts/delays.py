"""Pictures over the delay of states: `study robustness` and `study delay`."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter, MaxNLocator

from deploy.studies.charts.panels import Curve, heading, legend, panels, runs
from deploy.studies.study import Row
from deploy.telemetry.plot.style import FAINT

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
