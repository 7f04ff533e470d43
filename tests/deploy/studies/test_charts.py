"""Pictures of studies: what is where, that all of it is seen, and that marks say what the rows do."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from deploy.studies.charts import HOLLOW, Chart, delay, draw_study, plain_numbers, robustness
from deploy.studies.peers.chart import peers
from deploy.studies.study import Row
from deploy.telemetry.plot.workspace import RC


def contest_row(scenario: str, late: float, law: str, came: int, touched: int = 0, **over: Any) -> Row:
    tried = 6 if law in ("orca", "barrier") else 1
    return {
        "scenario": scenario,
        "delay": late,
        "law": law,
        "runs": 3,
        "arrived": came,
        "collisions": touched,
        "nrl_mean": 1.2 if came else None,
        "time_mean": 10.0 if came else None,
        "step_us": 40.0,
        "choice": "best",
        "scan": [{}] * tried,
    } | over


# As the study has them: late states amid fresh ones.
PEERS = [
    contest_row(scenario, late, law, came, touched)
    for scenario, late in (("swap 8", 0.0), ("swap 8, 50 ms late", 0.05), ("swap 12", 0.0))
    for law, came, touched in (
        ("reciprocal + lines", 3, 0),
        ("gradient + lines", 3, 0),
        ("gradient", 1, 2),
        ("orca", 2, 0),
        ("barrier", 0, 1),
    )
]
ROBUSTNESS: list[Row] = [
    {"filter": filter_, "delay": late, "loss": loss, "noise": noise, "period": 0.05, "runs": 10}
    | {"arrived": came, "collisions": 10 - came, "time_mean": 5.0 + late if came else None}
    for filter_, came in (("separating-lines", 10), ("none", 0))
    for late, loss, noise in ((0.0, 0.0, 0.0), (0.3, 0.0, 0.0), (0.0, 0.5, 0.0), (0.1, 0.1, 0.001))
]
DELAY: list[Row] = [
    {"scenario": scenario, "pace": pace, "delay": late, "runs": 20, "time_mean": 9.0 + late}
    | {"ratio": 1.0 + late, "ratio_error": late / 10 if late else None}
    for scenario in ("swap 10", "tight 3.30")
    for pace in ("common", "own")
    for late in (0.0, 0.1)
]
DRAWN: dict[str, Callable[[], Figure]] = {
    "peers": lambda: peers(PEERS),
    "robustness": lambda: robustness(ROBUSTNESS),
    "delay": lambda: delay(DELAY),
}


def marks(axes: Axes, wanted: Callable[[Line2D], bool]) -> int:
    return sum(int(np.size(line.get_xdata())) for line in axes.lines if wanted(line))


def crossed(line: Line2D) -> bool:
    return bool(line.get_marker() == "x")


def hollow(line: Line2D) -> bool:
    return bool(line.get_markerfacecolor() == HOLLOW) and not crossed(line)


def full(line: Line2D) -> bool:
    return not hollow(line) and not crossed(line)


@pytest.mark.parametrize("name", DRAWN)
def test_nothing_is_cut_off_and_the_legend_hides_no_data(name: str) -> None:
    with mpl.rc_context(RC):
        figure = DRAWN[name]()
        FigureCanvasAgg(figure).draw()  # type: ignore[no-untyped-call]
        (legend,) = figure.legends
        box = legend.get_window_extent()
        assert not any(box.overlaps(axes.get_window_extent()) for axes in figure.axes)
        for each in (box, figure._suptitle.get_window_extent()):  # type: ignore[attr-defined]
            assert figure.bbox.x0 <= each.x0 < each.x1 <= figure.bbox.x1
            assert figure.bbox.y0 <= each.y0 < each.y1 <= figure.bbox.y1


def test_every_run_has_a_mark_that_says_what_came_of_it() -> None:
    outcomes = peers(PEERS).axes[0]
    assert marks(outcomes, full) == sum(row["arrived"] for row in PEERS)
    assert marks(outcomes, crossed) == sum(row["collisions"] for row in PEERS)
    assert marks(outcomes, full) + marks(outcomes, hollow) == sum(row["runs"] for row in PEERS)


def test_means_over_some_of_the_runs_are_hollow() -> None:
    _, nrl, time, step = peers(PEERS).axes
    for axes in (nrl, time):
        assert (marks(axes, full), marks(axes, hollow)) == (6, 6)
    assert (marks(step, full), marks(step, hollow)) == (15, 0)


def test_robustness_has_a_column_for_every_loss_and_both_laws_in_it() -> None:
    figure = robustness(ROBUSTNESS)
    assert [axes.get_title() for axes in figure.axes[:2]] == ["0 % lost", "50 % lost"]
    assert len(figure.axes) == 6
    arrived, touched, time = figure.axes[0], figure.axes[2], figure.axes[4]
    values = [[list(curve[0].get_ydata()) for curve in axes.containers] for axes in (arrived, touched, time)]
    assert values == [[[100.0, 100.0], [0.0, 0.0]], [[0.0, 0.0], [100.0, 100.0]], [[5.0, 5.3], []]]


@pytest.mark.parametrize(("low", "high"), [(1.02, 1.2), (51.0, 52.0), (1.0, 5.9), (5.0, 300.0), (2.1, 12.7)])
def test_a_logarithmic_axis_has_numbers_to_read_it_by(low: float, high: float) -> None:
    axes = Figure().subplots()
    axes.set_xscale("log")
    axes.set_xlim(low, high)
    plain_numbers(axes.xaxis)
    assert sum(low <= tick <= high for tick in axes.get_xticks()) >= 2


@pytest.mark.parametrize(("chart", "rows"), [(peers, PEERS), (robustness, ROBUSTNESS), (delay, DELAY)])
def test_a_study_that_was_stopped_is_drawn_of_what_there_is(
    chart: Chart, rows: list[Row], tmp_path: Path
) -> None:
    draw_study(chart, rows[:1], tmp_path / "study.svg")
    assert (tmp_path / "study.svg").read_text().startswith("<?xml")
