"""What sampling costs: nrl of a fleet at its usual period against the exact continuous flow, run by run.

Run `python -m tests.benchmarks.theory.sampled` to print the table of docs/theory/propositions.md. The filter
is on, no faults and a period of 50 ms; the flow starts where the fleet does, at the same pace, and both end
when every robot is within the scenario's tolerance of its goal.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from agents.law.pace import max_rate
from deploy.library.figures import GOAL_SETS, TIGHTNESS, figure_3
from deploy.library.load import resolved
from deploy.output.bar import bar
from deploy.run.local import LocalFleet
from deploy.studies.statistics import error, mean
from deploy.theory.exact_flow import integrate
from deploy.theory.function import Problem
from protocol.scenario.model import Scenario

PERIOD = 0.05  # s
RUNS = 20

Pace = Literal["common", "own"]
PACES: tuple[Pace, ...] = ("common", "own")


@dataclass(frozen=True)
class Pair:
    """nrl of one start: of the fleet, and of the flow; None where it did not arrive."""

    sampled: float | None
    exact: float | None


def pair(scenario: Scenario) -> Pair:
    """Run the fleet in this process, and integrate the flow from the same start."""
    report = LocalFleet(scenario).execute()
    flow = integrate(
        Problem(
            np.array([robot.goal for robot in scenario.robots]),
            np.array([robot.radius for robot in scenario.robots]),
            scenario.workspace.disk_radius,
            scenario.k,
        ),
        np.array([robot.start for robot in scenario.robots]),
        "common" if "pace" in scenario.control.additions else "own",
        tolerance=scenario.time.tolerance,
        ease=_ease(scenario),
    )
    arrived = report["verdict"] == "arrived"
    return Pair(report["nrl"] if arrived else None, flow.nrl if flow.arrived else None)


def _ease(scenario: Scenario) -> float:
    """|D_i| at which a robot that saturates by itself leaves its speed limit, m."""
    time, speed = scenario.time, scenario.control.speed
    return speed / max_rate(speed, time.step, time.tolerance)


def instance(letter: str, pace: Pace, seed: int) -> Scenario:
    """Goal set `letter` from the random starts of `seed`, behind separating lines."""
    scenario = figure_3(letter, seed)
    control = scenario.control if pace == "common" else scenario.control.without("pace")
    return resolved(
        replace(
            scenario,
            control=replace(control, filter="separating-lines"),
            time=replace(scenario.time, step=PERIOD),
        )
    )


@dataclass(frozen=True)
class Row:
    """Means over the starts at which both arrived.

    ratio: mean of nrl of the fleet over that of the flow, start by start; largest: of these ratios.
    """

    goal_set: str
    tight: float
    pace: Pace
    runs: int
    compared: int
    sampled: float | None
    exact: float | None
    ratio: float | None
    ratio_error: float | None
    largest: float | None


def sampled_study(
    letters: Sequence[str] = tuple(GOAL_SETS), runs: int = RUNS, seed: int = 0
) -> Iterator[Row]:
    """A row for every goal set and pace; the same starts at both paces."""
    for pace in PACES:
        for letter in letters:
            yield row(letter, pace, [pair(instance(letter, pace, n)) for n in range(seed, seed + runs)])


def row(letter: str, pace: Pace, pairs: Sequence[Pair]) -> Row:
    """What the runs of one cell come to."""
    both = [(one.sampled, one.exact) for one in pairs if one.sampled is not None and one.exact is not None]
    ratios = [sampled / exact for sampled, exact in both]
    return Row(
        goal_set=letter,
        tight=TIGHTNESS[letter],
        pace=pace,
        runs=len(pairs),
        compared=len(both),
        sampled=mean([sampled for sampled, _ in both]),
        exact=mean([exact for _, exact in both]),
        ratio=mean(ratios),
        ratio_error=error(ratios),
        largest=max(ratios, default=None),
    )


def main() -> None:
    """Print the table as Markdown."""
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.theory.sampled", description=__doc__)
    parser.add_argument("--runs", type=int, default=RUNS, help=f"starts of each goal set; {RUNS}")
    runs = parser.parse_args().runs
    print("| goal set | tight | pace | compared | nrl at 50 ms | exact flow | ratio ± error | largest |")
    print("|---|---|---|---|---|---|---|---|")
    with bar("sampled") as tell:
        for done, each in enumerate(sampled_study(runs=runs), start=1):
            counts = f"| 3{each.goal_set} | {each.tight:.2f} | {each.pace} | {each.compared} of {each.runs} "
            ratio = f"{_number(each.ratio)} ± {_number(each.ratio_error)}"
            entries = (_number(each.sampled), _number(each.exact), ratio, _number(each.largest))
            print(f"{counts}| {' | '.join(entries)} |", flush=True)
            tell(done / (len(PACES) * len(GOAL_SETS)))


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3f}"


if __name__ == "__main__":
    main()
