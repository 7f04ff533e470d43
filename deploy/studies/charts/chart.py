"""Pictures of studies: each has one, drawn of its rows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from deploy.studies.charts.delays import delay, robustness
from deploy.studies.charts.panels import HOLLOW, Curve, heading, legend, panels, plain_numbers, runs
from deploy.studies.charts.peers import peers
from deploy.studies.study import Row
from deploy.telemetry.plot.style import INK, RC, colour

_SCALE = {
    "nrl_mean": "nrl",
    "ticks_per_second": "ticks per second",
    "cpu_per_robot_tick_us": "CPU per robot and tick, µs",
    "memory_mb": "memory, MB",
}
_OUTCOMES = ("arrived", "survivors_arrived", "barred", "not_arrived", "failed", "collisions")


def draw_study(name: str, rows: Sequence[Row], target: Path) -> None:
    """Draw the rows of the study `name` into `target`."""
    with mpl.rc_context(RC):
        metadata = {"Date": None} if target.suffix == ".svg" else {}
        _CHARTS[name](rows).savefig(target, metadata=metadata)


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


def _robustness(rows: Sequence[Row]) -> Figure:
    return robustness(rows) if "filter" in rows[0] else _random_faults(rows)


def _random_faults(rows: Sequence[Row]) -> Figure:
    """How many runs came to what, in numbers too: the few that matter are too few to be seen."""
    figure, ((axes,),) = panels(1, 1, 2.2)
    names = [name.replace("_", " ") for name in _OUTCOMES]
    bars = axes.barh(names, [rows[0][name] for name in _OUTCOMES], color=colour(0), height=0.6)
    axes.bar_label(bars, fmt="%d", padding=3)
    axes.invert_yaxis()
    axes.margins(x=0.1)
    axes.grid(visible=False, axis="y")
    axes.tick_params(axis="y", length=0)
    axes.set(xlabel="runs")
    heading(figure, f"{runs(rows)} with random faults")
    return figure


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


_CHARTS: dict[str, Callable[[Sequence[Row]], Figure]] = {
    "tightness": _tightness,
    "tuning": _tuning,
    "robustness": _robustness,
    "arrival": _arrival,
    "delay": delay,
    "scale": _scale,
    "peers": peers,
}
