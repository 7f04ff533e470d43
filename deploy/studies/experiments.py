"""The experiments of Karagoz, Bozma, Koditschek: figures 4 and 5, on the flow that the paper has.

The law is the paper's own at the common pace, no filter, perfect sensing and links. What remains between
a sampled fleet and the paper's continuous flow is the period, during which a robot's peers stand
still in its eyes. At `PERIOD` and 0.1 m/s that is 1 mm a tick, and nrl differs from that of the
exact flow by 0.1 % on average and by 2 % at most (figures 3a-3e, three starts each; at 0.02 s it is
0.6 % and 5 %, at 0.05 s 1.2 % and 11 %). The tolerance is small, because what a robot does not
drive at its end is missing in its path length: 0.5 mm are 0.2 %.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from deploy.library.figures import TIGHTNESS, figure_3
from deploy.studies.study import Cell, Result, Row, Study, arrived, deviation, mean
from protocol.scenario.model import Scenario

PERIOD = 0.01  # s
TOLERANCE = 0.0005  # m
LIMIT = 60.0  # s of simulated time
RUNS = 35
GAIN = 60.0  # figure 4
GAINS = (5.0, 8.0, 10.0, 15.0, 20.0, 30.0, 40.0, 60.0, 100.0, 300.0)  # figure 5, and below what it shows
GOAL_SET = "d"  # figure 5

# What the paper prints, and this law's exact continuous flow measured with other starts.
PRINTED_TIGHTNESS = {2.44: 1.08, 3.45: 1.25}
EXACT_TIGHTNESS = {2.44: 1.12, 2.63: 1.11, 2.87: 1.16, 3.30: 1.15, 3.45: 1.22}
PRINTED_TUNING = {20.0: 1.68}
EXACT_TUNING = {
    8.0: 2.44,
    10.0: 2.02,
    15.0: 1.61,
    20.0: 1.44,
    30.0: 1.28,
    40.0: 1.23,
    60.0: 1.20,
    100.0: 1.18,
    300.0: 1.17,
}

COLUMNS = {
    "tight": ".2f",
    "k": "g",
    "nrl_mean": ".3f",
    "nrl_std": ".3f",
    "arrived": "d",
    "runs": "d",
    "paper": ".2f",
    "exact": ".2f",
}


def tightness(runs: int = RUNS, seed: int = 0) -> Study:
    """Figure 4: nrl against tightness at k = 60; five goal sets, `runs` random starts each."""
    cells = [_cell(letter, GAIN, runs, seed) for letter in TIGHTNESS]
    return Study("tightness", cells, partial(_row, "tight", PRINTED_TIGHTNESS, EXACT_TIGHTNESS), COLUMNS)


def tuning(runs: int = RUNS, seed: int = 0) -> Study:
    """Figure 5: nrl against k on goal set 3d; the same `runs` random starts for every k."""
    cells = [_cell(GOAL_SET, k, runs, seed) for k in GAINS]
    return Study("tuning", cells, partial(_row, "k", PRINTED_TUNING, EXACT_TUNING), COLUMNS)


def paper_flow(letter: str, k: float, seed: int) -> Scenario:
    """Goal set `letter` from the random starts of `seed`, under the paper's law at gain `k`."""
    scenario = figure_3(letter, seed)
    return replace(
        scenario,
        control=replace(scenario.control, law="gradient", k=k, filter="none", additions=("pace",)),
        time=replace(scenario.time, step=PERIOD, tolerance=TOLERANCE, limit=LIMIT),
    )


def _cell(letter: str, k: float, runs: int, seed: int) -> Cell:
    labels = {"goals": f"figure-3{letter}", "tight": TIGHTNESS[letter], "k": k}
    return Cell(labels, partial(paper_flow, letter, k), range(seed, seed + runs))


def _row(
    axis: str,
    printed: Mapping[float, float],
    exact: Mapping[float, float],
    labels: Mapping[str, Any],
    results: Sequence[Result],
) -> Row:
    """nrl is over the runs that arrived, as the paper's is."""
    lengths = [result["nrl"] for result in arrived(results)]
    return {
        **labels,
        "nrl_mean": mean(lengths),
        "nrl_std": deviation(lengths),
        "arrived": len(lengths),
        "runs": len(results),
        "collisions": sum(result["collisions"] > 0 for result in results),
        "paper": printed.get(labels[axis]),
        "exact": exact.get(labels[axis]),
    }
