"""Figures over the runs of one cell."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from statistics import fmean, linear_regression, stdev
from typing import Any

Result = dict[str, Any]


def arrived(results: Iterable[Result]) -> list[Result]:
    """Those in which every robot reached its goal and nothing touched."""
    return [result for result in results if result["verdict"] == "arrived"]


def mean(values: Sequence[float]) -> float | None:
    """Mean; None of nothing."""
    return fmean(values) if values else None


def deviation(values: Sequence[float]) -> float | None:
    """Standard deviation of the sample; None of less than two."""
    return stdev(values) if len(values) > 1 else None


def error(values: Sequence[float]) -> float | None:
    """Standard error of the mean; None of less than two."""
    return stdev(values) / math.sqrt(len(values)) if len(values) > 1 else None


def collided(results: Iterable[Result]) -> int:
    """Runs in which something touched."""
    return sum(1 for result in results if result.get("collisions"))


def figures(results: Sequence[Result]) -> dict[str, Any]:
    """How many runs, of them those that touched and those that arrived, and mean nrl and time of these."""
    came = arrived(results)
    return {
        "runs": len(results),
        "collisions": collided(results),
        "arrived": len(came),
        "nrl_mean": mean([result["nrl"] for result in came]),
        "time_mean": mean([result["sim_time"] for result in came]),
    }


def untouched(rows: Sequence[Mapping[str, Any]]) -> bool:
    """Whether nothing touched in any run of these rows."""
    return not any(row["collisions"] for row in rows)


def growth(x: Sequence[float], y: Sequence[float]) -> float:
    """Exponent of the least-squares fit y = factor x^exponent in logarithms."""
    return linear_regression([math.log(each) for each in x], [math.log(each) for each in y]).slope
