"""Pictures of studies: figures 4 and 5 beside what the paper prints, and curves of the others."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from deploy.plot.style import INK, RC, colour, dash
from deploy.studies.study import Row

_WIDTH, _HEIGHT = 4.2, 3.0  # inches, one panel
Curves = Mapping[str, Sequence[tuple[Any, float | None]]]


def draw_study(name: str, rows: Sequence[Row], target: Path) -> None:
    """Draw the rows of the study `name` into `target`."""
    with mpl.rc_context(RC):
        metadata = {"Date": None} if target.suffix == ".svg" else {}
        _CHARTS[name](rows).savefig(target, metadata=metadata)


def _tightness(rows: Sequence[Row]) -> Figure:
    figure, (axes,) = _panels(1)
    _paper(axes, rows, "tight")
    axes.set(xlabel="tight", ylabel="normalised path length")
    return figure


def _tuning(rows: Sequence[Row]) -> Figure:
    figure, (axes,) = _panels(1)
    _paper(axes, rows, "k")
    axes.set(xlabel="k", ylabel="normalised path length", xscale="log")
    return figure


def _paper(axes: Axes, rows: Sequence[Row], axis: str) -> None:
    """Mean and deviation as measured, the paper's printed values, and the exact flow's."""
    known = [row for row in rows if row["nrl_mean"] is not None]
    axes.errorbar(
        [row[axis] for row in known],
        [row["nrl_mean"] for row in known],
        [row["nrl_std"] or 0.0 for row in known],
        color=colour(0),
        capsize=3,
        marker="o",
        markersize=4,
        label="measured, mean and deviation",
    )
    for name, marker, words in (("paper", "s", "printed in the paper"), ("exact", "x", "exact flow")):
        points = [(row[axis], row[name]) for row in rows if row[name] is not None]
        axes.plot(
            *_columns(points), marker, color=INK if name == "paper" else colour(1), markersize=5, label=words
        )
    axes.legend()


def _robustness(rows: Sequence[Row]) -> Figure:
    if rows and "filter" not in rows[0]:
        return _random_faults(rows)
    figure, panels = _panels(3)
    for axes, (name, words) in zip(
        panels,
        (
            ("collisions", "runs with a collision, %"),
            ("arrived", "runs that arrived, %"),
            ("time", "time, s"),
        ),
        strict=True,
    ):
        _curves(axes, _over_delay(rows, name))
        axes.set(xlabel="one-way delay, s", ylabel=words)
    panels[0].legend()
    return figure


def _over_delay(rows: Sequence[Row], name: str) -> Curves:
    """Curves over the delay, one for every filter and loss; noise and period as they mostly are."""
    curves: dict[str, list[tuple[Any, float | None]]] = {}
    for row in rows:
        if row["noise"] == 0.0 and row["period"] == 0.05:
            value = row["time_mean"] if name == "time" else 100.0 * row[name] / row["runs"]
            curves.setdefault(f"{row['filter']}, loss {row['loss']:g}", []).append((row["delay"], value))
    return curves


def _delay(rows: Sequence[Row]) -> Figure:
    """Time over the delay, and against the same runs without, one curve for each scenario and pace."""
    figure, panels = _panels(2)
    words = {"time_mean": "time, s", "ratio": "time against no delay"}
    for axes, (name, text) in zip(panels, words.items(), strict=True):
        curves: dict[str, list[tuple[Any, float | None]]] = {}
        for row in rows:
            curves.setdefault(f"{row['scenario']}, {row['pace']} pace", []).append((row["delay"], row[name]))
        _curves(axes, curves)
        axes.set(xlabel="one-way delay, s", ylabel=text)
    panels[0].legend()
    return figure


def _random_faults(rows: Sequence[Row]) -> Figure:
    figure, (axes,) = _panels(1)
    names = ("collisions", "arrived", "survivors_arrived", "barred", "not_arrived", "failed")
    axes.bar([name.replace("_", "\n") for name in names], [rows[0][name] for name in names], color=colour(0))
    axes.set(ylabel="runs")
    return figure


def _scale(rows: Sequence[Row]) -> Figure:
    wanted = {
        "nrl_mean": "nrl",
        "ticks_per_second": "ticks per second",
        "cpu_per_robot_tick_us": "CPU per robot and tick, µs",
        "memory_mb": "memory, MB",
    }
    figure, panels = _panels(len(wanted))
    for axes, (name, words) in zip(panels, wanted.items(), strict=True):
        curves: dict[str, list[tuple[Any, float | None]]] = {}
        for row in rows:
            curves.setdefault(row["transport"], []).append((row["robots"], row[name]))
        _curves(axes, curves)
        axes.set(
            xlabel="robots", ylabel=words, xscale="log", yscale="linear" if name == "nrl_mean" else "log"
        )
    panels[0].legend()
    return figure


def _peers(rows: Sequence[Row]) -> Figure:
    figure, panels = _panels(2)
    for axes, name in zip(panels, ("arrived", "collisions"), strict=True):
        curves: dict[str, list[tuple[Any, float | None]]] = {}
        for row in rows:
            curves.setdefault(row["law"], []).append((row["scenario"], 100.0 * row[name] / row["runs"]))
        _curves(axes, curves)
        axes.set(ylabel=f"runs: {name}, %")
        axes.tick_params(axis="x", rotation=90)
    panels[0].legend()
    return figure


def _panels(count: int) -> tuple[Figure, list[Axes]]:
    figure = Figure(figsize=(_WIDTH * count, _HEIGHT), layout="constrained")
    return figure, list(figure.subplots(1, count, squeeze=False)[0])


def _curves(axes: Axes, curves: Curves) -> None:
    for index, (label, points) in enumerate(curves.items()):
        known = [(x, y) for x, y in points if y is not None]
        axes.plot(
            *_columns(known), marker="o", markersize=3, color=colour(index), ls=dash(index), label=label
        )


def _columns(points: Sequence[tuple[Any, Any]]) -> tuple[list[Any], list[Any]]:
    return [x for x, _ in points], [y for _, y in points]


_CHARTS: dict[str, Callable[[Sequence[Row]], Figure]] = {
    "tightness": _tightness,
    "tuning": _tuning,
    "robustness": _robustness,
    "delay": _delay,
    "scale": _scale,
    "peers": _peers,
}
