"""What sampling costs: nrl of a fleet at its usual period against the exact continuous flow, run by run.

The filter is on, no faults, period 50 ms; the flow starts where the fleet does, and both end when every
robot is within the scenario's tolerance of its goal. Prints the table of docs/results/theory.md.

    python -m tests.benchmarks.theory.sampled
"""

import argparse
from dataclasses import replace

import numpy as np

from deploy.library.instances import GOAL_SETS, TIGHTNESS, figure_3
from deploy.library.load import resolved
from deploy.run.local import LocalFleet
from deploy.studies.study import error, mean
from deploy.theory.exact_flow import integrate
from deploy.theory.function import FleetProblem
from protocol.scenario.model import Scenario

PERIOD = 0.05  # s
RUNS = 20


def pair(scenario: Scenario) -> tuple[float, float] | None:
    """nrl of the fleet and of the flow from the same start; None where one did not arrive."""
    report = LocalFleet(scenario).execute()
    goals, starts = (np.array([getattr(each, end) for each in scenario.robots]) for end in ("goal", "start"))
    radii = np.array([each.radius for each in scenario.robots])
    problem = FleetProblem(goals, radii, scenario.workspace.disk_radius, scenario.k)
    flow = integrate(problem, starts, tolerance=scenario.time.tolerance)
    return (report["nrl"], flow.nrl) if report["verdict"] == "arrived" and flow.arrived else None


def instance(letter: str, seed: int) -> Scenario:
    """Goal set `letter` from the random starts of `seed`, behind separating lines."""
    scenario = figure_3(letter, seed)
    control = replace(scenario.control, filter="separating-lines")
    return resolved(replace(scenario, control=control, time=replace(scenario.time, step=PERIOD)))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--runs", type=int, default=RUNS, help=f"starts of each goal set; {RUNS}")
    runs = parser.parse_args().runs
    print("| goal set | tight | compared | nrl at 50 ms | exact flow | ratio ± error | largest |")
    print("|---|---|---|---|---|---|---|")
    for letter in GOAL_SETS:
        pairs = [both for seed in range(runs) if (both := pair(instance(letter, seed)))]
        ratios = [sampled / exact for sampled, exact in pairs]
        means = [f"{mean(column):.3f}" for column in (*zip(*pairs, strict=True), ratios)]
        spread = f"{means[2]} ± {error(ratios) or 0.0:.3f}"
        print(
            f"| 3{letter} | {TIGHTNESS[letter]:.2f} | {len(pairs)} of {runs} | {means[0]} | {means[1]} "
            f"| {spread} | {max(ratios):.3f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
