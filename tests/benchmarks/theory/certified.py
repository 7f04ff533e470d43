"""k = "auto" beside the certified K and the k below which starts fail, for random goal sets.

Run `python -m tests.benchmarks.theory.certified --write` to measure again and rewrite the table of
docs/results/certified-k.md.
"""

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from deploy.output import bar
from deploy.theory.certify.certificate import Certificate, GoalSet
from deploy.theory.certify.prove import prove
from deploy.theory.exact_flow import random_configuration
from deploy.theory.function import FleetProblem
from deploy.theory.tuning import automatic_k
from protocol.arrays import Reals
from protocol.draws import Purpose, generator
from tests.benchmarks.theory.smallest_k import arrival_threshold, arrives_from_all

MARKER = "<!-- measured -->"
REPORT = Path(__file__).parents[3] / "docs" / "results" / "certified-k.md"
PICTURE = REPORT.parents[1] / "pictures" / "certified-k.png"
RADIUS, WORKSPACE = 0.04, 0.30  # m
STARTS = 10
LOWEST = 1.1  # k, below which starts are not tried
ROBOTS = (2, 3, 4)


@dataclass(frozen=True)
class Row:
    """One goal set.

    auto: the rule's k; certified: the smallest K proven within the boxes, None when none was; fails: the
    largest k at which a random start was seen to fail, None when none did from LOWEST on.
    """

    robots: int
    auto: float
    certified: float | None
    fails: float | None
    boxes: int
    seconds: float


def rows(sets: int, boxes: int) -> Iterator[Row]:
    """Goal sets of 2, 3 and 4 robots in turn; the same arguments give the same rows but for `seconds`."""
    for number in range(sets):
        draw = generator(number, Purpose.SCENARIO)
        radii = np.full(ROBOTS[number % len(ROBOTS)], RADIUS)
        goals, *starts = (random_configuration(draw, radii, WORKSPACE) for _ in range(1 + STARTS))
        problem = FleetProblem(goals, radii, WORKSPACE, automatic_k(radii, WORKSPACE))
        found = _certified(problem, boxes)
        fails = _fails(problem, [start for start in starts if start is not None])
        yield Row(problem.p, problem.k, found.proven, fails, found.boxes, found.time)


def _certified(problem: FleetProblem, boxes: int) -> Certificate:
    """As far down as so many boxes reach."""
    places = tuple((float(x), float(y)) for x, y in problem.goals)
    certificate = Certificate(goals=GoalSet(places, tuple(problem.radii.tolist()), problem.workspace))
    for now in prove(certificate, LOWEST):
        if now.boxes + (now.trial.boxes if now.trial else 0) >= boxes:
            break
    return certificate


def _fails(problem: FleetProblem, starts: Sequence[Reals]) -> float | None:
    if arrives_from_all(replace(problem, k=LOWEST), starts):
        return None
    if not arrives_from_all(problem, starts):
        return problem.k
    return arrival_threshold(problem, starts, LOWEST)[0]


def table(found: Sequence[Row]) -> str:
    head = "| robots | auto | certified K | a start fails at k | K over that | boxes | s |"
    lines = [head, "|---" * 7 + "|"]
    for row in sorted(found, key=lambda row: (row.robots, row.certified or np.inf)):
        certified = "-" if row.certified is None else f"{row.certified:g}"
        fails = "-" if row.fails is None else f"{row.fails:.2f}"
        ratio = "-" if row.fails is None or row.certified is None else f"{row.certified / row.fails:.1f}"
        cost = f"{row.boxes:,} | {row.seconds:.1f}"
        lines.append(f"| {row.robots} | {row.auto:g} | {certified} | {fails} | {ratio} | {cost} |")
    covered = sum(row.certified is not None and row.certified <= row.auto for row in found)
    share = f'`k = "auto"` is covered by the proof in {covered} of {len(found)} goal sets.'
    return "\n".join([*lines, "", share, ""])


def draw(found: Sequence[Row], path: Path) -> None:
    """The same as a picture: k against goal set, logarithmic."""
    import matplotlib.pyplot as plt

    from deploy.telemetry.plot.workspace import COLOURS, RC

    ordered = sorted(found, key=lambda row: (row.robots, row.certified or np.inf))
    with plt.rc_context(RC):
        figure, axes = plt.subplots(figsize=(6.4, 3.0), layout="constrained")
        series = (
            ("auto", [row.auto for row in ordered], "_"),
            ("certified K: proven from here up", [row.certified or np.nan for row in ordered], "o"),
            ("a random start fails", [row.fails or np.nan for row in ordered], "v"),
        )
        for (name, values, shape), colour in zip(series, COLOURS, strict=False):
            axes.plot(range(len(ordered)), values, shape, color=colour, markersize=4, label=name)
        for p in ROBOTS[1:]:
            first = next((n for n, row in enumerate(ordered) if row.robots == p), None)
            if first is not None:
                axes.axvline(first - 0.5, color="#888888", linewidth=0.6)
        axes.set(yscale="log", xlabel="goal sets of 2, 3 and 4 robots", ylabel="k", xticks=[])
        axes.legend()
        figure.savefig(path, metadata={"Software": None})
        plt.close(figure)


def main() -> None:
    """Measure, and print the table, or put it below the marker of the report, with the picture."""
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.theory.certified", description=__doc__)
    parser.add_argument("--sets", type=int, default=50, help="goal sets")
    parser.add_argument("--boxes", type=int, default=300_000, help="boxes for each")
    parser.add_argument("--write", action="store_true", help=f"replace the table in {REPORT.name}")
    options = parser.parse_args()
    found = []
    with bar("goal sets") as tell:
        for row in rows(options.sets, options.boxes):
            found.append(row)
            tell(len(found) / options.sets)
    if options.write:
        REPORT.write_text(REPORT.read_text().split(MARKER)[0] + MARKER + "\n\n" + table(found))
        draw(found, PICTURE)
    else:
        print(table(found))


if __name__ == "__main__":
    main()
