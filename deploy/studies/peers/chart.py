"""The picture of `study peers`: every scenario is a row across all panels, with a lane for every law."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import zip_longest
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from deploy.studies.charts import HOLLOW, heading, legend, panels, plain_numbers, runs
from deploy.studies.peers.study import NAMES
from deploy.studies.study import Row
from deploy.telemetry.plot.workspace import FAINT, INK, colour, marker

_LANES = 0.8  # of a row
_GAP = 0.5  # of a row, between delays
_ROW, _REST = 0.265, 1.7  # inches: a row; what is above and below all rows
_BAND = "#f2f2f2"
_SIZE, _SAMPLE = 3.6, 5.0  # points, of marks in panels and in the legend
_RUNS = 70.0  # points, room for the marks of all runs side by side
_STEPS = {"nrl_mean": (1.0, 1.5, 2.0, 3.0, 5.0), "time_mean": (1.0, 2.0, 5.0), "step_us": (1.0, 2.0, 5.0)}
_WORDS = {"nrl_mean": "nrl", "time_mean": "time, s", "step_us": "CPU a step, µs"}


def peers(rows: Sequence[Row]) -> Figure:
    """What came of the runs, nrl, time and cost, of every scenario and law."""
    rows = [row for row in rows if row["choice"] == "best"]
    where, laws = _places(rows), list(dict.fromkeys(row["law"] for row in rows))
    known = [name for name in _WORDS if any(row[name] is not None for row in rows)]
    height = _ROW * (max(where.values()) + 1.0) + _REST
    figure, ((first, *others),) = panels(
        1, 1 + len(known), height, sharey=True, width_ratios=(0.75, *(1.0 for _ in known))
    )
    for axes in (first, *others):
        _lay_out(axes, where)
    _outcomes(first, rows, where, laws)
    for axes, name in zip(others, known, strict=True):
        _values(axes, rows, where, laws, name)
    heading(figure, *_said(rows))
    legend(figure, _legend(laws))
    return figure


def _places(rows: Sequence[Row]) -> dict[str, float]:
    """How far down each scenario is, in rows: fresh states first, then by delay, each after a gap."""
    delays = {row["scenario"]: row["delay"] for row in rows}
    ranks = {delay: rank for rank, delay in enumerate(sorted(set(delays.values())))}
    order = sorted(delays, key=lambda name: ranks[delays[name]])
    return {name: n + _GAP * ranks[delays[name]] for n, name in enumerate(order)}


def _lay_out(axes: Axes, where: Mapping[str, float]) -> None:
    for y in list(where.values())[::2]:
        axes.axhspan(y - 0.5, y + 0.5, color=_BAND, linewidth=0, zorder=0)
    axes.set_ylim(max(where.values()) + 0.5, -0.5)
    axes.set_yticks(list(where.values()), list(where))
    axes.grid(visible=False, axis="y")
    axes.tick_params(axis="y", length=0)
    axes.tick_params(axis="x", top=True, labeltop=True)
    axes.spines["top"].set_visible(True)


def _lane(row: Row, where: Mapping[str, float], laws: Sequence[str]) -> float:
    lane = laws.index(row["law"]) - 0.5 * (len(laws) - 1)
    return where[row["scenario"]] + _LANES / len(laws) * lane


def _outcomes(axes: Axes, rows: Sequence[Row], where: Mapping[str, float], laws: Sequence[str]) -> None:
    """A mark a run: first those that arrived, then those that touched, then those that never arrived."""
    most = max(row["runs"] for row in rows)
    size = min(_SIZE, _RUNS / most)
    for row in rows:
        came, touched = row["arrived"], row["collisions"]
        lane, place = _lane(row, where, laws), laws.index(row["law"])
        marks = [(n, lane) for n in range(1, row["runs"] + 1)]
        _mark(axes, place, marks[:came], size)
        _mark(axes, place, marks[came:], size, hollow=True)
        axes.plot(*_columns(marks[came : came + touched]), "x", color=INK, ms=1.7 * size, mew=0.7)
    axes.set(xlabel="runs", title="outcome", xlim=(0.3, most + 0.7))
    axes.xaxis.set_major_locator(MaxNLocator(integer=True, nbins=6))


def _values(
    axes: Axes, rows: Sequence[Row], where: Mapping[str, float], laws: Sequence[str], name: str
) -> None:
    """Means; hollow those of nrl and time that not all runs are in."""
    axes.set_xscale("log")
    for row in rows:
        if row[name] is not None:
            whole = name == "step_us" or row["arrived"] == row["runs"]
            point = (row[name], _lane(row, where, laws))
            _mark(axes, laws.index(row["law"]), [point], _SIZE, hollow=not whole)
    axes.set(xlabel=_WORDS[name], title=_WORDS[name])
    plain_numbers(axes.xaxis, _STEPS[name])


def _mark(
    axes: Axes, place: int, points: Sequence[tuple[float, float]], size: float, *, hollow: bool = False
) -> None:
    axes.plot(*_columns(points), linestyle="", **_look(place, size, hollow=hollow))


def _look(place: int, size: float, *, hollow: bool = False) -> dict[str, Any]:
    shade = colour(place)
    return {
        "marker": marker(place),
        "markersize": size,
        "color": shade,
        "markerfacecolor": HOLLOW if hollow else shade,
        "markeredgewidth": 0.8,
    }


def _columns(points: Sequence[tuple[float, float]]) -> tuple[list[float], list[float]]:
    return [x for x, _ in points], [y for _, y in points]


def _said(rows: Sequence[Row]) -> Iterator[str]:
    """What a mark stands for."""
    yield f"{runs(rows)} of every law in every scenario, from the same starts"
    scanned = [row for row in rows if len(row["scan"]) > 1]
    if scanned:
        names = dict.fromkeys(NAMES.get(row["law"], str(row["law"])) for row in scanned)
        tried = sorted({len(row["scan"]) for row in scanned})
        yield (
            f"{' and '.join(names)}: the best setting of each scenario,"
            f" of {' or '.join(map(str, tried))} tried on these very runs"
        )
    yield "nrl and time: mean of the runs that arrived; hollow where not all did, no mark where none did"


def _legend(shown: Sequence[str]) -> dict[str, Any]:
    """Laws in one line and outcomes in the next: legends are filled column by column."""
    laws = [(NAMES.get(law, law), _sample(marker(n), colour(n))) for n, law in enumerate(shown)]
    full, empty = _sample("o", FAINT), _sample("o", FAINT, HOLLOW)
    cross = Line2D([], [], linestyle="", marker="x", color=INK, markersize=1.7 * _SAMPLE, mew=0.7)
    outcomes = [("arrived", full), ("did not arrive", empty), ("touched", (empty, cross))]
    pairs = zip_longest(laws, outcomes)
    return dict(each for pair in pairs for each in pair if each is not None)


def _sample(form: str, shade: str, face: str | None = None) -> Line2D:
    return Line2D([], [], linestyle="", marker=form, color=shade, markerfacecolor=face or shade, ms=_SAMPLE)
