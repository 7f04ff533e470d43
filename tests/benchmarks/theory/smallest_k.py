"""The k below which other minima catch the exact flow, for the goal sets of figure 3, and nrl at k = 60.

Run `python -m tests.benchmarks.theory.smallest_k` to print the table of docs/results/theory.md.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from deploy.library.instances import GOAL_SETS, RADIUS, TIGHTNESS, WORKSPACE, random_starts
from deploy.theory.exact_flow import integrate
from deploy.theory.function import FleetProblem
from protocol.arrays import Reals


def arrives_from_all(problem: FleetProblem, starts: Sequence[Reals]) -> bool:
    """Whether the exact flow brings every one of these starts (p, 2) to the goal."""
    return all(integrate(problem, start).arrived for start in starts)


def arrival_threshold(
    problem: FleetProblem, starts: Sequence[Reals], low: float = 1.0
) -> tuple[float, float]:
    """(k at which some start fails, k at which all arrive), within a factor of 1.05.

    Bisection on log k between `low`, taken to fail, and problem.k, taken to arrive. It finds one change from
    failure to arrival; that arrival is monotone in k is observed, not proven.
    """
    high = problem.k
    while high > 1.05 * low:
        middle = float(np.sqrt(low * high))
        arrives = arrives_from_all(replace(problem, k=middle), starts)
        low, high = (low, middle) if arrives else (middle, high)
    return low, high


def main() -> None:
    starts = [np.array(random_starts([RADIUS] * 6, WORKSPACE, seed)) for seed in range(30)]
    print("| goal set | tight | some start fails at k | all arrive from k | nrl at k = 60 |")
    print("|---|---|---|---|---|")
    for letter, goals in GOAL_SETS.items():
        problem = FleetProblem(np.array(goals), np.full(6, RADIUS), WORKSPACE, 60.0)
        fails, arrives = arrival_threshold(problem, starts)
        nrl = [integrate(problem, start).nrl for start in starts]
        print(
            f"| 3{letter} | {TIGHTNESS[letter]:.2f} | {fails:.1f} | {arrives:.1f}"
            f" | {np.mean(nrl):.2f} ± {np.std(nrl):.2f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
