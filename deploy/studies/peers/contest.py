"""Rows of `study peers`: the best setting of each law in each scenario, with all other settings attached."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from deploy.studies.study import Result, Row, Study, arrived, error, figures, mean, untouched
from protocol.scenario.model import Scenario

REFERENCE = "reciprocal + lines"  # paired with all others
_SCANNED = {
    "horizon": "horizon {:g} s",
    "gain": "alpha {:g}/s",
    "noise": "noise {:g}",
    "margin": "margin {:g} m",
}
_Tried = dict[str, list["Attempt"]]  # by scenario, for one group of scenarios and one law


@dataclass(frozen=True)
class Attempt:
    """One setting of a law in a scenario: its row, and its results by seed."""

    row: Row
    results: Mapping[int, Result]


class Contest(Study):
    """One row for every scenario and law, with its best setting; the row's `scan` has all settings.

    If several settings were tried, a second row shows the single setting that is best over the whole group.
    """

    def rows(self, results: Mapping[tuple[int, int], Result]) -> list[Row]:
        found = []
        for tried in self._tried(results).values():
            single = _single(tried)
            for scenario, attempts in tried.items():
                scan = [each.row for each in attempts]
                top = next(each for each in attempts if each.row is best(scan))
                found.append((scenario, top, {"choice": "best", "scan": scan}))
                found += [
                    (scenario, each, {"choice": "single", "scan": []})
                    for each in attempts
                    if each.row["setting"] == single
                ]
        reference = {scenario: each for scenario, each, _ in found if each.row["law"] == REFERENCE}
        rows = [
            each.row | _paired(each, reference.get(scenario)) | choice for scenario, each, choice in found
        ]
        order = {cell.labels["scenario"]: n for n, cell in reversed(list(enumerate(self.cells)))}
        return sorted(rows, key=lambda each: order[each["scenario"]])

    def _tried(self, results: Mapping[tuple[int, int], Result]) -> dict[tuple[str, str], _Tried]:
        tried: defaultdict[tuple[str, str], _Tried] = defaultdict(lambda: defaultdict(list))
        least: dict[tuple[str, int], float] = {}
        for n, cell in enumerate(self.cells):
            scenario, known = cell.labels["scenario"], dict[int, Result]()
            for seed in cell.seeds:
                if (n, seed) in results:
                    if (scenario, seed) not in least:
                        least[scenario, seed] = least_time(cell.build(seed))
                    known[seed] = results[n, seed] | {"least_time": least[scenario, seed]}
            if known:
                attempt = Attempt(self.row(cell.labels, list(known.values())), known)
                tried[cell.labels["group"], cell.labels["law"]][scenario].append(attempt)
        return tried


def least_time(scenario: Scenario) -> float:
    """Time of the longest straight path from start to goal at the speed limit, s."""
    return max(math.dist(each.start, each.goal) for each in scenario.robots) / scenario.control.speed


def best(rows: Sequence[Row]) -> Row:
    """Row with most arrivals, then fewest collisions, then least time; the first of equals."""
    return min(rows, key=_demerit)


def _demerit(each: Mapping[str, Any]) -> tuple[float, ...]:
    time = each["time_mean"]
    return -each["arrived"], each["collisions"], float("inf") if time is None else time


def _single(tried: _Tried) -> str | None:
    """Setting that is best over all scenarios together; None if only one was tried."""
    by_setting: defaultdict[str, list[Row]] = defaultdict(list)
    for attempts in tried.values():
        for each in attempts:
            by_setting[each.row["setting"]].append(each.row)
    whole = {setting: rows for setting, rows in by_setting.items() if len(rows) == len(tried)}
    if len(by_setting) < 2 or not whole:
        return None

    def demerit(setting: str) -> tuple[float, ...]:
        rows = whole[setting]
        slowness = [row["limit_mean"] for row in rows if row["limit_mean"] is not None]
        return -_sum(rows, "arrived"), _sum(rows, "collisions"), mean(slowness) or float("inf")

    return min(whole, key=demerit)


def _paired(one: Attempt, reference: Attempt | None) -> Row:
    """Ratios of nrl and time to those of the reference, over the starts from which both arrived."""
    mine, theirs = _came(one), {} if reference is None else _came(reference)
    seeds = [seed for seed in mine if seed in theirs]
    found: Row = {"paired": len(seeds)}
    for name, field in (("nrl", "nrl"), ("time", "sim_time")):
        ratios = [mine[seed][field] / theirs[seed][field] for seed in seeds if theirs[seed][field]]
        found |= {f"{name}_ratio": mean(ratios), f"{name}_ratio_error": error(ratios)}
    return found


def _came(attempt: Attempt) -> dict[int, Result]:
    return {seed: each for seed, each in attempt.results.items() if each["verdict"] == "arrived"}


def row(labels: Mapping[str, Any], results: Sequence[Result]) -> Row:
    """The usual statistics, and:

    limit: time over `least_time`. reached: number of runs in which all arrived, with or without contact.
    step_us: CPU time per robot and tick, decoding included; None except on the in-process bus.
    """
    limit = [each["sim_time"] / each["least_time"] for each in arrived(results) if each.get("least_time")]
    steps = [
        1e6 * result["robots_cpu_s"] / (result["ticks"] * len(result["robots"]))
        for result in results
        if result.get("robots_cpu_s") and result["ticks"]
    ]
    return {
        **labels,
        **figures(results),
        "setting": ", ".join(form.format(labels[key]) for key, form in _SCANNED.items() if key in labels),
        "reached": sum(set(each.get("robots", (0,))) <= set(each.get("arrived", ())) for each in results),
        "limit_mean": mean(limit),
        "limit_error": error(limit),
        "step_us": mean(steps),
    }


def summary(rows: Sequence[Row]) -> list[str]:
    """Each law over all scenarios, with the best setting in each; then with one setting per group."""
    lines = []
    for law in dict.fromkeys(each["law"] for each in rows):
        own = [each for each in rows if each["law"] == law]
        top = [each for each in own if each["choice"] == "best"]
        lines.append(f"{law}: {_outcome(top)}{_beside(top)}")
        for group in dict.fromkeys(each["group"] for each in own if each["choice"] == "single"):
            alone = [each for each in own if each["choice"] == "single" and each["group"] == group]
            tried = [each for one in top if one["group"] == group for each in one["scan"]]
            lines.append(
                f"  {group}: {alone[0]['setting']} alone: {_outcome(alone)}{_beside(alone)};"
                f" all {len({each['setting'] for each in tried})} settings: {_outcome(tried)}"
            )
    return lines


def _outcome(rows: Sequence[Row]) -> str:
    runs, came, touched = (_sum(rows, each) for each in ("runs", "arrived", "collisions"))
    return f"{came} of {runs} arrived, {touched} collided"


def _beside(rows: Sequence[Row]) -> str:
    known = [each for each in rows if each["law"] != REFERENCE and each["time_ratio"] is not None]
    if not known:
        return ""
    shorter, quicker = (sum(each[name] > 1.0 for each in known) for name in ("nrl_ratio", "time_ratio"))
    return f"; {REFERENCE} is shorter in {shorter} and quicker in {quicker} of {len(known)} scenarios"


def _sum(rows: Sequence[Row], name: str) -> int:
    return int(sum(each[name] for each in rows))


def sound(rows: Sequence[Row]) -> bool:
    """Whether runs with separating lines had no collisions."""
    return untouched([each for each in rows if each["law"].endswith("+ lines")])
