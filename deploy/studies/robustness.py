"""`study robustness`: what delay, loss, noise and the period do, with and without separating lines.

Six robots on the tight goal set 3d. Delay and loss are crossed; noise and period are varied one by one
around a network of 100 ms delay and 10 % loss. Everything twice: with the filter, and the bare law.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal

from deploy.library.figures import figure_3
from deploy.studies.study import Cell, Result, Row, Study, figures, untouched
from protocol.scenario.model import Link, Scenario, Sensing

DELAYS = (0.0, 0.05, 0.1, 0.2, 0.3, 0.5, 1.0)  # s, one way
LOSSES = (0.0, 0.1, 0.3, 0.5)
NOISES = (0.0005, 0.001, 0.003)  # m, standard deviation, truncated at three of them
PERIODS = (0.02, 0.1, 0.2)  # s
LIMIT = 120.0  # s of simulated time
RUNS = 10

Filter = Literal["separating-lines", "none"]
FILTERS: tuple[Filter, ...] = ("separating-lines", "none")
COLUMNS = {
    "filter": "",
    "delay": "g",
    "loss": "g",
    "noise": "g",
    "period": "g",
    "runs": "d",
    "collisions": "d",
    "arrived": "d",
    "nrl_mean": ".3f",
    "time_mean": ".1f",
    "min_clearance": ".5f",
}


@dataclass(frozen=True)
class Conditions:
    """One point of the grid, s and m; the defaults are what noise and period are varied around."""

    delay: float = 0.1
    loss: float = 0.1
    noise: float = 0.0
    period: float = 0.05


def grid() -> Iterator[Conditions]:
    """Delay by loss, then noise, then period."""
    for delay in DELAYS:
        for loss in LOSSES:
            yield Conditions(delay, loss)
    for noise in NOISES:
        yield Conditions(noise=noise)
    for period in PERIODS:
        yield Conditions(period=period)


def robustness(runs: int = RUNS, seed: int = 0, conditions: Sequence[Conditions] | None = None) -> Study:
    """`runs` random starts at every point; the same starts everywhere."""
    points = list(grid()) if conditions is None else conditions
    cells = [_cell(point, filter_, runs, seed) for filter_ in FILTERS for point in points]
    return Study("robustness", cells, _row, COLUMNS, _summary, _sound)


def faulty(point: Conditions, filter_: Filter, seed: int) -> Scenario:
    """Goal set 3d from the random starts of `seed` under these conditions."""
    scenario = figure_3("d", seed)
    return replace(
        scenario,
        control=replace(scenario.control, filter=filter_),
        time=replace(scenario.time, step=point.period, limit=LIMIT),
        link=Link(delay=point.delay, loss=point.loss),
        sensing=(Sensing(noise=point.noise),),
    )


def _cell(point: Conditions, filter_: Filter, runs: int, seed: int) -> Cell:
    labels = {
        "filter": filter_,
        "delay": point.delay,
        "loss": point.loss,
        "noise": point.noise,
        "period": point.period,
    }
    return Cell(labels, partial(faulty, point, filter_), range(seed, seed + runs))


def _row(labels: Mapping[str, Any], results: Sequence[Result]) -> Row:
    """nrl and time are over the runs in which all arrived and nothing touched."""
    return {
        **labels,
        **figures(results),
        "min_clearance": min(result["min_clearance"] for result in results),
    }


def _summary(rows: Sequence[Row]) -> list[str]:
    lines = []
    for filter_ in FILTERS:
        own = [row for row in rows if row["filter"] == filter_]
        runs, touched = (sum(row[name] for row in own) for name in ("runs", "collisions"))
        came = sum(row["arrived"] for row in own)
        lines.append(f"filter {filter_}: {touched} of {runs} runs collided, {came} arrived")
    return lines


def _sound(rows: Sequence[Row]) -> bool:
    """Whether separating lines kept what they promise."""
    return untouched([row for row in rows if row["filter"] == "separating-lines"])
