"""Figures over the runs of one cell."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from statistics import fmean, stdev
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


def power_law(x: Sequence[float], y: Sequence[float]) -> tuple[float, float]:
    """Factor and exponent of the least-squares fit y = factor x^exponent in logarithms."""
    u, v = [math.log(each) for each in x], [math.log(each) for each in y]
    mu, mv = fmean(u), fmean(v)
    spread = sum((a - mu) ** 2 for a in u)
    exponent = sum((a - mu) * (b - mv) for a, b in zip(u, v, strict=True)) / spread
    return math.exp(mv - exponent * mu), exponent
