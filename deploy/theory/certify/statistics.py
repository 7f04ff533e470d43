"""Where no proof can be had in time: how often the exact flow fails, with an exact confidence bound.

A statement about the distribution of the starts, at one k. It is not a proof, and says nothing about other k.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from deploy.theory.configurations import random_configuration
from deploy.theory.exact_flow import integrate
from deploy.theory.function import Problem
from protocol.draws import Purpose, generator
from protocol.errors import UsageError

CONFIDENCE = 0.95


@dataclass(frozen=True)
class FailingFraction:
    """failed of `starts` did not arrive; at_most: Clopper and Pearson's one-sided upper bound."""

    k: float
    starts: int
    failed: int
    at_most: float

    def __str__(self) -> str:
        return (
            f"k = {self.k:g}: {self.failed} of {self.starts} random starts did not arrive. With "
            f"{CONFIDENCE:.0%} confidence at most {self.at_most:.3g} of such starts fail (Clopper-Pearson): "
            "statistics, no proof"
        )


def failing_fraction(
    problem: Problem, starts: int, seed: int, tell: Callable[[float], None]
) -> FailingFraction:
    """Follow the exact flow from random free configurations, drawn from `seed`; the same ones for every k.

    Raises:
        UsageError: no free configuration was found.
    """
    failed = 0
    for number in range(starts):
        draw = generator(seed, Purpose.STUDY, tick=number)
        start = random_configuration(draw, problem.radii, problem.workspace)
        if start is None:
            raise UsageError("no free configuration was found to start from: the workspace is too crowded")
        failed += not integrate(problem, start).arrived
        tell((number + 1) / starts)
    return FailingFraction(problem.k, starts, failed, upper_bound(failed, starts))


def upper_bound(failed: int, starts: int) -> float:
    """Clopper and Pearson's upper bound of the failing fraction, one-sided, at CONFIDENCE."""
    from scipy.stats import binomtest

    return float(binomtest(failed, starts, alternative="less").proportion_ci(CONFIDENCE, "exact").high)
