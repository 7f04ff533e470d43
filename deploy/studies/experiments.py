"""The experiments of Karagöz, Bozma, Koditschek, figures 4 and 5, under the paper's law; and fleet sizes.

The law is the paper's, at the common pace, without filter, with perfect sensing and links. A sampled fleet
differs from the continuous flow by its period, during which robots assume static peers. With `PERIOD` and
0.1 m/s, 1 mm a tick, nrl differs from the exact flow by 0.1 % on average and by 2 % at most (figures 3a-3e,
three starts each; at 0.02 s by 0.6 % and 5 %, at 0.05 s by 1.2 % and 11 %). The tolerance of arrival is
small, since the rest of the way is missing in the path length: 0.2 % for 0.5 mm.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from deploy.library.instances import TIGHTNESS, figure_3, random_instance
from deploy.library.load import resolved
from deploy.run.options import Transport
from deploy.run.result import RunResult
from deploy.studies.study import Cell, Row, Study, figures, growth, mean
from protocol.scenario.model import Scenario

PERIOD = 0.01  # s
TOLERANCE = 0.0005  # m
LIMIT = 60.0  # s of simulated time
RUNS = 35
GAIN = 60.0  # figure 4
GAINS = (5.0, 8.0, 10.0, 15.0, 20.0, 30.0, 40.0, 60.0, 100.0, 300.0)  # figure 5, and smaller ones
GOAL_SET = "d"  # figure 5

# Values of the paper, and of the exact flow from other starts.
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
COLUMNS = "tight k nrl_mean nrl_std arrived runs paper exact"


def tightness(runs: int = RUNS, seed: int = 0) -> Study:
    """Figure 4: nrl against tightness at k = 60; five goal sets, `runs` random starts each."""
    cells = [_cell(letter, GAIN, runs, seed) for letter in TIGHTNESS]
    return Study("tightness", cells, COLUMNS, partial(_row, "tight", PRINTED_TIGHTNESS, EXACT_TIGHTNESS))


def tuning(runs: int = RUNS, seed: int = 0) -> Study:
    """Figure 5: nrl against k on goal set 3d; the same `runs` random starts for every k."""
    cells = [_cell(GOAL_SET, k, runs, seed) for k in GAINS]
    return Study("tuning", cells, COLUMNS, partial(_row, "k", PRINTED_TUNING, EXACT_TUNING))


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
    results: Sequence[RunResult],
) -> Row:
    x = labels[axis]
    return {**labels, **figures(results), "paper": printed.get(x), "exact": exact.get(x)}


# -- scale: path, time, speed and memory against the number of robots, on each transport

ROBOTS = (3, 6, 12, 16, 24, 32, 48, 64)
TRANSPORTS: tuple[Transport, ...] = ("routed", "local")
_FITTED = {
    "nrl_mean": "nrl",
    "time_mean": "simulated time",
    "ticks_per_second": "ticks per second",
    "cpu_per_robot_tick_us": "CPU per robot and tick",
    "memory_mb": "memory",
}


def scale(
    runs: int = 3, seed: int = 0, robots: Sequence[int] = ROBOTS, transports: Sequence[Transport] = TRANSPORTS
) -> Study:
    """Random instances at the paper's density with the filter on; `runs` for every number of robots."""
    cells = [
        Cell({"transport": bus, "robots": count}, partial(instance, count), range(seed, seed + runs), bus)
        for bus in transports
        for count in robots
    ]
    columns = (
        "transport robots k runs arrived nrl_mean time_mean ticks_per_second cpu_per_robot_tick_us memory_mb "
        "memory_per_robot_mb"
    )
    return Study("scale", cells, columns, _costs, _growth)


def instance(count: int, seed: int) -> Scenario:
    """`count` robots with random starts and goals, and a long time limit."""
    drawn = resolved(random_instance(count, seed))
    return replace(drawn, time=replace(drawn.time, limit=2.0 * LIMIT))


def _costs(labels: Mapping[str, Any], results: Sequence[RunResult]) -> Row:
    """Adds speed, CPU and memory; resident memory is summed, so shared pages count for each process."""
    robots = labels["robots"]
    rows = [process for result in results for process in result["processes"]]
    own = [row["max_rss_mb"] for row in rows if row["name"].startswith("robot-")]
    return {
        **labels,
        **figures(results),
        "k": results[0]["k"],
        "ticks_per_second": mean([result["ticks_per_second"] for result in results]),
        "cpu_per_robot_tick_us": mean(
            [1e6 * _sum(result, "cpu_s") / result["ticks"] / robots for result in results]
        ),
        "memory_mb": mean([_sum(result, "max_rss_mb") for result in results]),
        "memory_per_robot_mb": mean(own),
    }


def _sum(result: RunResult, name: str) -> float:
    """Over all processes, their start and end included."""
    return float(sum(process[name] for process in result["processes"]))


def _growth(rows: Sequence[Row]) -> list[str]:
    """Growth exponents for each transport, by least squares over logarithms."""
    lines = []
    for transport in dict.fromkeys(row["transport"] for row in rows):
        fits = []
        for name, words in _FITTED.items():
            points = [
                (row["robots"], row[name]) for row in rows if row["transport"] == transport and row[name]
            ]
            if len({x for x, _ in points}) > 1:
                exponent = growth([x for x, _ in points], [y for _, y in points])
                fits.append(f"{words} p^{exponent:+.2f}")
        lines.append(f"{transport}, p robots: " + ", ".join(fits))
    return lines
