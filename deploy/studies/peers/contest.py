"""Rows of `study peers`: the best setting of each law in each scenario, with all settings attached."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from deploy.run.result import RunResult
from deploy.studies.study import Row, Study, arrived, error, figures, mean, untouched
from protocol.scenario.model import Scenario

REFERENCE = "reciprocal + lines"  # paired with all others
_SCANNED = {
    "horizon": "horizon {:g} s",
    "gain": "alpha {:g}/s",
    "noise": "noise {:g}",
    "margin": "margin {:g} m",
}


@dataclass(frozen=True)
class Attempt:
    """One setting of a law in a scenario: its row, and its results by seed."""

    row: Row
    results: Mapping[int, RunResult]


class Contest(Study):
    """One row for every scenario and law, with its best setting; the row's `scan` has all settings."""

    def rows(self, results: Mapping[tuple[int, int], RunResult]) -> list[Row]:
        found = []
        for (scenario, _), attempts in self._tried(results).items():
            scan = [each.row for each in attempts]
            top = next(each for each in attempts if each.row is best(scan))
            found.append((scenario, top, {"scan": scan}))
        reference = {scenario: each for scenario, each, _ in found if each.row["law"] == REFERENCE}
        return [each.row | _paired(each, reference.get(scenario)) | scan for scenario, each, scan in found]

    def _tried(self, results: Mapping[tuple[int, int], RunResult]) -> dict[tuple[str, str], list[Attempt]]:
        """All settings by scenario and law, in the order of the cells."""
        tried: defaultdict[tuple[str, str], list[Attempt]] = defaultdict(list)
        least: dict[tuple[str, int], float] = {}
        for n, cell in enumerate(self.cells):
            scenario, known = cell.labels["scenario"], dict[int, RunResult]()
            for seed in cell.seeds:
                if (n, seed) in results:
                    if (scenario, seed) not in least:
                        least[scenario, seed] = least_time(cell.build(seed))
                    known[seed] = results[n, seed] | {"least_time": least[scenario, seed]}
            if known:
                attempt = Attempt(self.row(cell.labels, list(known.values())), known)
                tried[scenario, cell.labels["law"]].append(attempt)
        return tried


def least_time(scenario: Scenario) -> float:
    """Time of the longest straight path from start to goal at the speed limit, s."""
    return max(math.dist(each.start, each.goal) for each in scenario.robots) / scenario.control.speed


def best(rows: Sequence[Row]) -> Row:
    """Row with most arrivals, then fewest collisions, then least time; the first of equals."""

    def demerit(each: Row) -> tuple[float, ...]:
        time = each["time_mean"]
        return -each["arrived"], each["collisions"], math.inf if time is None else time

    return min(rows, key=demerit)


def _paired(one: Attempt, reference: Attempt | None) -> Row:
    """Ratios of nrl and time to those of the reference, over the starts from which both arrived."""
    mine, theirs = _came(one), {} if reference is None else _came(reference)
    seeds = [seed for seed in mine if seed in theirs]
    found: Row = {"paired": len(seeds)}
    for name, field in (("nrl", "nrl"), ("time", "sim_time")):
        ratios = [mine[seed][field] / theirs[seed][field] for seed in seeds if theirs[seed][field]]
        found |= {f"{name}_ratio": mean(ratios), f"{name}_ratio_error": error(ratios)}
    return found


def _came(attempt: Attempt) -> dict[int, RunResult]:
    return {seed: each for seed, each in attempt.results.items() if each["verdict"] == "arrived"}


def row(labels: Mapping[str, Any], results: Sequence[RunResult]) -> Row:
    """The usual statistics, and limit: time over `least_time`; reached: number of runs in which all arrived,
    with or without contact.
    """
    limit = [each["sim_time"] / each["least_time"] for each in arrived(results) if each.get("least_time")]
    return {
        **labels,
        **figures(results),
        "setting": ", ".join(form.format(labels[key]) for key, form in _SCANNED.items() if key in labels),
        "reached": sum(set(each.get("robots", (0,))) <= set(each.get("arrived", ())) for each in results),
        "limit_mean": mean(limit),
        "limit_error": error(limit),
    }


def summary(rows: Sequence[Row]) -> list[str]:
    """Each law over all scenarios, with the best setting in each."""
    lines = []
    for law in dict.fromkeys(row["law"] for row in rows):
        own = [row for row in rows if row["law"] == law]
        runs, came, touched = (sum(row[name] for row in own) for name in ("runs", "arrived", "collisions"))
        lines.append(f"{law}: {came} of {runs} arrived, {touched} collided{_beside(own)}")
    return lines


def _beside(rows: Sequence[Row]) -> str:
    known = [each for each in rows if each["law"] != REFERENCE and each["time_ratio"] is not None]
    if not known:
        return ""
    shorter, quicker = (sum(each[name] > 1.0 for each in known) for name in ("nrl_ratio", "time_ratio"))
    return f"; {REFERENCE} is shorter in {shorter} and quicker in {quicker} of {len(known)} scenarios"


def sound(rows: Sequence[Row]) -> bool:
    """Whether runs with separating lines had no collisions."""
    return untouched([each for each in rows if each["law"].endswith("+ lines")])
