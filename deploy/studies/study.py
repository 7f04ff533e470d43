"""Studies: cells of seeded runs, rows of a table, and statistics over the runs of a cell."""

from __future__ import annotations

import hashlib
import math
import pickle
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from statistics import fmean, linear_regression, stdev
from typing import Any, Self

from deploy.library.load import resolved
from deploy.run.options import Transport
from deploy.run.result import RunResult
from protocol.errors import UsageError
from protocol.scenario.file import apply_settings, document_of, parse_document
from protocol.scenario.model import Scenario

Row = dict[str, Any]

Build = Callable[[int], Scenario]


@dataclass(frozen=True)
class Cell:
    """The runs of one row: the scenario that `build` gives for each of `seeds`."""

    labels: Mapping[str, Any]  # identify the cell, and begin its row
    build: Build  # picklable; its scenarios have k as a number
    seeds: Sequence[int]
    transport: Transport | None = None  # default: the study's


@dataclass(frozen=True)
class StudyRun:
    """One run of a study, with the key of its result."""

    cell: int
    seed: int
    transport: Transport
    key: str


@dataclass(frozen=True)
class Study:
    """Cells, and how to make rows of their results."""

    name: str
    cells: Sequence[Cell]
    columns: str  # of the printed table, separated by blanks
    # Row from a cell's labels and its results, in the order of seeds.
    row: Callable[[Mapping[str, Any], Sequence[RunResult]], Row] = lambda labels, results: {
        **labels,
        **figures(results),
    }
    summary: Callable[[Sequence[Row]], list[str]] = lambda _: []  # lines below the table
    sound: Callable[[Sequence[Row]], bool] = lambda _: True  # all promises are kept, such as no collisions

    def adjusted(self, settings: Sequence[str]) -> Study:
        """The study with `path.to.key=VALUE` settings applied to every scenario."""
        if not settings:
            return self
        cells = [
            replace(cell, build=partial(adjusted_scenario, cell.build, tuple(settings)))
            for cell in self.cells
        ]
        return replace(self, cells=cells)

    def runs(self, transport: Transport, code: str) -> list[StudyRun]:
        """All runs; `code`, a digest of the software, keeps results of other versions apart."""
        found = []
        for n, cell in enumerate(self.cells):
            bus = cell.transport or transport
            settings = pickle.dumps((self.name, dict(cell.labels), cell.build, bus, code), protocol=4)
            digest = hashlib.sha256(settings).hexdigest()[:16]
            found += [StudyRun(n, seed, bus, f"{self.name}/{digest}/{seed}") for seed in cell.seeds]
        return found

    def rows(self, results: Mapping[tuple[int, int], RunResult]) -> list[Row]:
        """One row for every cell with results; `results` by cell and seed."""
        rows = []
        for n, cell in enumerate(self.cells):
            known = [results[n, seed] for seed in cell.seeds if (n, seed) in results]
            if known:
                rows.append(self.row(cell.labels, known))
        return rows


def adjusted_scenario(build: Build, settings: Sequence[str], seed: int) -> Scenario:
    """The scenario of `seed` with the settings applied.
    Raises ScenarioError if one names no key, or gives an invalid scenario.
    """
    scenario = build(seed)
    return resolved(parse_document(apply_settings(document_of(scenario), settings), scenario.name))


@dataclass(frozen=True)
class Shard:
    """Every `of`-th run of a study from the `number`-th on (from 1): a part for one machine.

    The shards of a study are disjoint and complete. Their concatenated logs are the log of the whole.
    """

    number: int = 1
    of: int = 1

    @classmethod
    def parse(cls, text: str) -> Self:
        """From "I/N"; raises UsageError."""
        found = re.fullmatch(r"([1-9]\d{0,5})/([1-9]\d{0,5})", text)
        if found is None or int(found[1]) > int(found[2]):
            raise UsageError(f"--shard {text}: give I/N with I from 1 to N, such as 3/16")
        return cls(int(found[1]), int(found[2]))

    def __str__(self) -> str:
        return f"{self.number}/{self.of}"

    def part(self, runs: Sequence[StudyRun]) -> Sequence[StudyRun]:
        """Runs of this shard."""
        return runs[self.number - 1 :: self.of]


def arrived(results: Iterable[RunResult]) -> list[RunResult]:
    """Results in which every robot arrived without contact."""
    return [result for result in results if result["verdict"] == "arrived"]


def mean(values: Sequence[float]) -> float | None:
    """Mean; None if empty."""
    return fmean(values) if values else None


def error(values: Sequence[float]) -> float | None:
    """Standard error of the mean; None of fewer than two values."""
    return stdev(values) / math.sqrt(len(values)) if len(values) > 1 else None


def figures(results: Sequence[RunResult]) -> dict[str, Any]:
    """Statistics of every row: numbers of runs, of those with collisions and of those that arrived; nrl and
    time (s) of the latter, with deviations and standard errors; smallest clearance (m) of all runs.
    """
    came = arrived(results)
    nrl, time = [result["nrl"] for result in came], [result["sim_time"] for result in came]
    return {
        "runs": len(results),
        "collisions": sum(1 for result in results if result.get("collisions")),
        "arrived": len(came),
        "nrl_mean": mean(nrl),
        "nrl_std": stdev(nrl) if len(nrl) > 1 else None,
        "nrl_error": error(nrl),
        "time_mean": mean(time),
        "time_error": error(time),
        "time_max": max(time, default=None),
        "min_clearance": min((result.get("min_clearance", math.inf) for result in results), default=None),
    }


def untouched(rows: Sequence[Mapping[str, Any]]) -> bool:
    """Whether there were no collisions in these rows."""
    return not any(row["collisions"] for row in rows)


def growth(x: Sequence[float], y: Sequence[float]) -> float:
    """Exponent of the least-squares fit y = factor x^exponent in logarithms."""
    return linear_regression([math.log(each) for each in x], [math.log(each) for each in y]).slope
