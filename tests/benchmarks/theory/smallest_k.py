"""The k below which other minima catch the exact flow, for the goal sets of figure 3.

Run `python -m tests.benchmarks.theory.smallest_k` to print the table of docs/results/theory.md.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from deploy.library.instances import RADIUS, WORKSPACE, figure_3, random_starts
from deploy.theory.exact_flow import integrate
from deploy.theory.function import Array, FleetProblem
from world.judge.clearance import Disks
from world.judge.measures import Goals, tight


@dataclass(frozen=True)
class Row:
    """fails: largest k tried at which a start did not arrive; arrives: smallest at which all did."""

    goal_set: str
    tight: float
    fails: float
    arrives: float
    nrl_mean: float
    nrl_std: float


def arrives_from_all(problem: FleetProblem, starts: Sequence[Array]) -> bool:
    """Whether the exact flow brings every one of these starts (p, 2) to the goal."""
    return all(integrate(problem, start).arrived for start in starts)


def arrival_threshold(problem: FleetProblem, starts: Sequence[Array]) -> tuple[float, float]:
    """(k at which some start fails, k at which all arrive), within a factor of 1.05.

    Bisection on log k between 1, taken to fail, and problem.k, taken to arrive. It finds one change from
    failure to arrival; that arrival is monotone in k is observed, not proven.
    """
    low, high = 1.0, problem.k
    while high > 1.05 * low:
        middle = float(np.sqrt(low * high))
        arrives = arrives_from_all(replace(problem, k=middle), starts)
        low, high = (low, middle) if arrives else (middle, high)
    return low, high


def smallest_k_study() -> Iterator[Row]:
    """One row per goal set: the threshold, and nrl of the same starts at k = 60."""
    starts = [np.array(random_starts([RADIUS] * 6, WORKSPACE, seed)) for seed in range(30)]
    for letter in "abcde":
        scenario = figure_3(letter)
        goals = [robot.goal for robot in scenario.robots]
        problem = FleetProblem(np.array(goals), np.full(6, RADIUS), WORKSPACE, 60.0)
        fails, arrives = arrival_threshold(problem, starts)
        lengths = [integrate(problem, start).nrl for start in starts]
        mean, deviation = float(np.mean(lengths)), float(np.std(lengths))
        yield Row(
            letter, tight(Disks.of(scenario), Goals.of(scenario)) or 0.0, fails, arrives, mean, deviation
        )


def main() -> None:
    print("| goal set | tight | some start fails at k | all arrive from k | nrl at k = 60 |")
    print("|---|---|---|---|---|")
    for row in smallest_k_study():
        entries = (f"{row.tight:.2f}", f"{row.fails:.1f}", f"{row.arrives:.1f}")
        print(
            f"| 3{row.goal_set} | {' | '.join(entries)} | {row.nrl_mean:.2f} ± {row.nrl_std:.2f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
