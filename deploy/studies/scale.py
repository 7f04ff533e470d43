"""`study scale`: what the number of robots does to path, time, speed and memory, on each transport."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from deploy.library.load import resolved
from deploy.library.random_instances import random_instance
from deploy.run.options import Transport
from deploy.studies.study import Cell, Result, Row, Study, arrived, growth, mean
from protocol.scenario.model import Scenario

ROBOTS = (3, 6, 12, 16, 24, 32, 48, 64)
TRANSPORTS: tuple[Transport, ...] = ("routed", "local")
LIMIT = 120.0  # s of simulated time
RUNS = 3
COLUMNS = {
    "transport": "",
    "robots": "d",
    "k": ".0f",
    "runs": "d",
    "arrived": "d",
    "nrl_mean": ".3f",
    "time_mean": ".1f",
    "ticks_per_second": ".0f",
    "cpu_per_robot_tick_us": ".0f",
    "memory_mb": ".0f",
    "memory_per_robot_mb": ".1f",
}
_FITTED = {
    "nrl_mean": "nrl",
    "time_mean": "simulated time",
    "ticks_per_second": "ticks per second",
    "cpu_per_robot_tick_us": "CPU per robot and tick",
    "memory_mb": "memory",
}


def scale(
    runs: int = RUNS,
    seed: int = 0,
    robots: Sequence[int] = ROBOTS,
    transports: Sequence[Transport] = TRANSPORTS,
) -> Study:
    """Random instances at the paper's density with the filter on; `runs` for every number of robots."""
    cells = [
        Cell({"transport": bus, "robots": count}, partial(crowd, count), range(seed, seed + runs), bus)
        for bus in transports
        for count in robots
    ]
    return Study("scale", cells, _row, COLUMNS, _summary)


def crowd(count: int, seed: int) -> Scenario:
    """`count` robots, random starts and goals, time enough."""
    instance = resolved(random_instance(count, seed))
    return replace(instance, time=replace(instance.time, limit=LIMIT))


def _row(labels: Mapping[str, Any], results: Sequence[Result]) -> Row:
    """memory: resident, summed over processes, so that what they share counts for each of them."""
    came, robots = arrived(results), labels["robots"]
    memory = mean([_memory(result) for result in results])
    own = [process["max_rss_mb"] for result in results for process in _robots(result)]
    return {
        **labels,
        "k": results[0]["k"],
        "runs": len(results),
        "arrived": len(came),
        "nrl_mean": mean([result["nrl"] for result in came]),
        "time_mean": mean([result["sim_time"] for result in came]),
        "ticks_per_second": mean([result["ticks_per_second"] for result in results]),
        "cpu_per_robot_tick_us": mean([1e6 * _cpu(result) / result["ticks"] / robots for result in results]),
        "memory_mb": memory,
        "memory_per_robot_mb": mean(own) if own else None,
    }


def _robots(result: Result) -> list[dict[str, Any]]:
    return [process for process in result["processes"] if process["name"].startswith("robot-")]


def _memory(result: Result) -> float:
    return float(result.get("max_rss_mb") or sum(process["max_rss_mb"] for process in result["processes"]))


def _cpu(result: Result) -> float:
    """CPU of all processes, s; start and end included."""
    return float(result.get("cpu_s") or sum(process["cpu_s"] for process in result["processes"]))


def _summary(rows: Sequence[Row]) -> list[str]:
    """Growth exponents: least squares over the logarithms, of all rows of one transport."""
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
