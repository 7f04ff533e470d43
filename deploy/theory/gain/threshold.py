"""The k below which other minima catch the flow, measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from deploy.theory.exact_flow import integrate
from deploy.theory.function import Array, Problem


def arrives_from_all(problem: Problem, starts: Sequence[Array]) -> bool:
    """Whether the exact flow brings every one of these starts (p, 2) to the goal."""
    return all(integrate(problem, start).arrived for start in starts)


def arrival_threshold(
    problem: Problem, starts: Sequence[Array], low: float, high: float, ratio: float = 1.05
) -> tuple[float, float]:
    """(k at which some start fails, k at which all arrive), within a factor of `ratio`; ignores problem.k.

    Bisection on log k between `low`, taken to fail, and `high`, taken to arrive. It finds one change from
    failure to arrival; that arrival is monotone in k is observed, not proven.
    """
    while high > ratio * low:
        middle = float(np.sqrt(low * high))
        arrives = arrives_from_all(replace(problem, k=middle), starts)
        low, high = (low, middle) if arrives else (middle, high)
    return low, high
