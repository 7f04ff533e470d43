"""The study behind k = "auto": random instances, the exact flow, several multiples of the rule.

Run `python -m tests.benchmarks.theory.auto_k` to print the tables of docs/results/auto-k.md anew.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from deploy.theory.check import mirrored_triples
from deploy.theory.exact_flow import integrate, random_configuration
from deploy.theory.function import FleetProblem
from deploy.theory.tuning import automatic_k
from protocol.draws import Purpose, generator
from protocol.errors import UsageError

Array = NDArray[np.float64]


def instance(draw: np.random.Generator, p: int, density: float, ratio: float) -> tuple[FleetProblem, Array]:
    """A problem, its k set by the automatic rule, and a start (p, 2).

    density: area of the disks over area of the workspace; ratio: largest over smallest possible radius.
    Radii are log-uniform between, largest first.

    Raises:
        UsageError: no free configuration was found at this density.
    """
    radii: Array = np.sort(ratio ** draw.uniform(0.0, 1.0, p))[::-1]
    workspace = float(np.sqrt((radii**2).sum() / density))
    goals = random_configuration(draw, radii, workspace)
    start = random_configuration(draw, radii, workspace)
    if goals is None or start is None:
        raise UsageError(f"no free configuration of {p} disks found at density {density:g}; use a lower one")
    return FleetProblem(goals, radii, workspace, automatic_k(radii, workspace)), start


ROBOTS = (3, 4, 6, 8, 12, 16, 24, 32)
DENSITIES = (0.10, 0.20, 0.30, 0.35)
RATIOS = (1.0, 2.0)
FACTORS = (0.25, 0.5, 1.0, 2.0, 4.0)


@dataclass(frozen=True)
class Row:
    """One cell: `runs` instances that are not provably unreachable, how many arrived, mean nrl of those."""

    robots: int
    density: float
    ratio: float
    factor: float
    runs: int
    arrived: int
    nrl: float
    unreachable: int
    failed: tuple[int, ...]  # numbers of the instances that did not arrive


def _cell(p: int, density: float, ratio: float, factor: float, instances: range) -> Row:
    nrl, failed, unreachable = [], [], 0
    for number in instances:
        draw = generator(number, Purpose.STUDY, robot=p)
        problem, start = instance(draw, p, density, ratio)
        if mirrored_triples(problem, start):
            unreachable += 1
            continue
        flow = integrate(replace(problem, k=factor * problem.k), start)
        if flow.arrived:
            nrl.append(flow.nrl)
        else:
            failed.append(number)
    mean = float(np.mean(nrl)) if nrl else float("nan")
    runs = len(nrl) + len(failed)
    return Row(p, density, ratio, factor, runs, len(nrl), mean, unreachable, tuple(failed))


def _entry(rows: Sequence[Row]) -> str:
    """arrived/runs and mean nrl over several cells."""
    runs, arrived = sum(row.runs for row in rows), sum(row.arrived for row in rows)
    lengths = [row.nrl for row in rows if row.arrived]
    return f"{arrived}/{runs}, {np.mean(lengths):.2f}" if lengths else f"{arrived}/{runs}"


def _table(rows: Sequence[Row], axis: str) -> list[str]:
    """Markdown: one line per value of `axis`, one column per density."""
    densities = sorted({row.density for row in rows})
    lines = [f"| {axis} \\ density | " + " | ".join(f"{d:g}" for d in densities) + " |"]
    lines += ["|---" * (len(densities) + 1) + "|"]
    for value in sorted({getattr(row, axis) for row in rows}):
        cells = [[r for r in rows if (getattr(r, axis), r.density) == (value, d)] for d in densities]
        lines.append(f"| {value:g} | " + " | ".join(map(_entry, cells)) + " |")
    return [*lines, ""]


def summary(rows: Sequence[Row]) -> str:
    """Markdown: factor by density over all numbers of robots, then robots by density at the rule itself."""
    rule = [row for row in rows if row.factor == 1.0]
    skipped = sum(row.unreachable for row in rule)
    failed = [
        f"{r.robots} robots, density {r.density:g}, ratio {r.ratio:g}: {r.failed}" for r in rule if r.failed
    ]
    lines = ["Arrived / instances, mean nrl; k in multiples (factor) of the rule:", ""]
    lines += _table(rows, "factor")
    lines += ["At the rule itself (factor 1):", ""]
    lines += _table(rule, "robots")
    lines += [f"At the rule: {_entry(rule)} over all. Provably unreachable, left out: {skipped}."]
    lines += ["Instances that did not arrive at the rule's k: " + ("; ".join(failed) or "none") + "."]
    return "\n".join(lines) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.theory.auto_k", description=__doc__)
    parser.add_argument("--runs", type=int, default=40, help="instances per cell")
    runs = range(parser.parse_args().runs)
    print(summary([_cell(*cell, runs) for cell in product(ROBOTS, DENSITIES, RATIOS, FACTORS)]))


if __name__ == "__main__":
    main()
