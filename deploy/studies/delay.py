"""`study delay`: what late states cost in time, for a swap and for tight goals, at both paces.

Every run is compared with the run of the same start and pace without delay; delay is one way and the
same for all states, and nothing else is wrong.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, Literal

from deploy.library.figures import figure_3
from deploy.library.load import resolved
from deploy.library.swaps import swap
from deploy.studies.study import Build, Cell, Result, Row, Study, arrived, error, figures, mean, untouched
from protocol.scenario.model import Link, Scenario

RUNS = 20
DELAYS = (0.0, 0.1, 0.3)  # s, one way
LIMIT = 120.0  # s of simulated time
JITTER = 0.01  # m, of the starts of a swap: an exact saddle costs a time of its own

Pace = Literal["common", "own"]
PACES: tuple[Pace, ...] = ("common", "own")
PLACES: dict[str, Build] = {"swap 10": partial(swap, 10, JITTER), "tight 3.30": partial(figure_3, "d")}
COLUMNS = {
    "scenario": "",
    "pace": "",
    "delay": "g",
    "runs": "d",
    "collisions": "d",
    "arrived": "d",
    "nrl_mean": ".3f",
    "time_mean": ".2f",
    "ratio": ".3f",
    "ratio_error": ".3f",
}


class Delays(Study):
    """Rows that also say how many times as long the runs took as without delay."""

    def rows(self, results: Mapping[tuple[int, int], Result]) -> list[Row]:
        """See `Study.rows`; no ratio where the runs without delay are not known."""
        rows = super().rows(results)
        prompt = {(row["scenario"], row["pace"]): row["times"] for row in rows if row["delay"] == 0.0}
        return [row | against(row["times"], prompt.get((row["scenario"], row["pace"]), {})) for row in rows]


def delay(runs: int = RUNS, seed: int = 0, delays: Sequence[float] = DELAYS) -> Study:
    """`runs` starts of either scenario at either pace; the same starts at every one of `delays`, s."""
    cells = [
        Cell(
            {"scenario": name, "pace": pace, "delay": late},
            partial(delayed, build, pace, late),
            range(seed, seed + runs),
        )
        for name, build in PLACES.items()
        for pace in PACES
        for late in delays
    ]
    return Delays("delay", cells, row, COLUMNS, summary, untouched)


def delayed(build: Build, pace: Pace, late: float, seed: int) -> Scenario:
    """The scenario of `seed` at this pace, every state `late` s old when it is heard."""
    scenario = build(seed)
    return resolved(
        replace(
            scenario,
            control=scenario.control if pace == "common" else scenario.control.without("pace"),
            link=Link(delay=late),
            time=replace(scenario.time, limit=LIMIT),
        )
    )


def row(labels: Mapping[str, Any], results: Sequence[Result]) -> Row:
    """nrl and time are over the runs in which all arrived and nothing touched; times by seed, s."""
    times = {str(result["seed"]): result["sim_time"] for result in arrived(results)}
    return {**labels, **figures(results), "times": times}


def against(late: Mapping[str, float], prompt: Mapping[str, float]) -> dict[str, float | None]:
    """Mean time over mean time, of the seeds that both have, and the standard error of that ratio."""
    seeds = [seed for seed in late if seed in prompt]
    base = mean([prompt[seed] for seed in seeds])
    whole = mean([late[seed] for seed in seeds])
    if base is None or whole is None:
        return {"ratio": None, "ratio_error": None}
    ratio = whole / base
    spread = error([late[seed] - ratio * prompt[seed] for seed in seeds])
    return {"ratio": ratio, "ratio_error": None if spread is None else spread / base}


def summary(rows: Sequence[Row]) -> list[str]:
    """Both paces side by side, for each scenario and delay."""
    times = {(row["scenario"], row["delay"], row["pace"]): row["time_mean"] for row in rows}
    lines = []
    for name, late in dict.fromkeys((scenario, late) for scenario, late, _ in times):
        common, own = (times.get((name, late, pace)) for pace in PACES)
        if common is not None and own is not None:
            lines.append(
                f"{name}, {1e3 * late:g} ms: own pace takes {own / common:.2f} of the common pace's time"
            )
    return lines
