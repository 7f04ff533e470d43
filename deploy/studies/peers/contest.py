"""A study whose rows are the best setting of each law in each scenario, with all others kept beside."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import Any

from deploy.studies.statistics import arrived, collided, mean
from deploy.studies.study import Result, Row, Study

_SCANNED = {
    "horizon": "horizon {:g} s",
    "barrier_gain": "alpha {:g}/s",
    "symmetry_noise": "noise {:g}",
    "margin": "margin {:g} m",
}


class Contest(Study):
    """One row for every scenario and law: its best setting; `scan` of the row has all of them."""

    def rows(self, results: Mapping[tuple[int, int], Result]) -> list[Row]:
        """See `Study.rows`."""
        tried: defaultdict[tuple[str, str], list[Row]] = defaultdict(list)
        for each in super().rows(results):
            tried[each["scenario"], each["law"]].append(each)
        return [best(rows) | {"scan": rows} for rows in tried.values()]


def best(rows: Sequence[Row]) -> Row:
    """The row with most arrivals, then fewest collisions, then least time; of equals the first."""
    return min(rows, key=_demerit)


def _demerit(each: Mapping[str, Any]) -> tuple[float, ...]:
    time = each["time_mean"]
    return -each["arrived"], each["collisions"], float("inf") if time is None else time


def row(labels: Mapping[str, Any], results: Sequence[Result]) -> Row:
    """nrl and time are over the runs in which all arrived and nothing touched.

    reached: runs in which all arrived, touching or not. step_us: CPU of a robot a tick, decoding of
    what it heard included, on the in-process bus; None elsewhere.
    """
    came = arrived(results)
    steps = [
        1e6 * result["robots_cpu_s"] / (result["ticks"] * len(result["robots"]))
        for result in results
        if result.get("robots_cpu_s") and result["ticks"]
    ]
    return {
        **labels,
        "setting": ", ".join(form.format(labels[key]) for key, form in _SCANNED.items() if key in labels),
        "runs": len(results),
        "arrived": len(came),
        "collisions": collided(results),
        "reached": sum(set(each.get("robots", (0,))) <= set(each.get("arrived", ())) for each in results),
        "nrl_mean": mean([result["nrl"] for result in came]),
        "time_mean": mean([result["sim_time"] for result in came]),
        "step_us": mean(steps),
    }


def summary(rows: Sequence[Row]) -> list[str]:
    """Each law over all scenarios, with its best setting in each; then with one setting, and with all."""
    lines = []
    for law in dict.fromkeys(each["law"] for each in rows):
        own = [each for each in rows if each["law"] == law]
        lines.append(f"{law}: {_outcome(own)}")
        lines += _single("without delay", [each for each in own if not each["delay"]])
        lines += _single("with delays", [each for each in own if each["delay"]])
    return lines


def _single(where: str, own: Sequence[Row]) -> list[str]:
    """What all settings come to together, and the best single one, where several were tried."""
    tried: defaultdict[str, list[Row]] = defaultdict(list)
    for each in own:
        for setting in each["scan"]:
            tried[setting["setting"]].append(setting)
    if len(tried) < 2:
        return []
    everywhere = [rows for rows in tried.values() if len(rows) == len(own)]
    single = min(everywhere, key=lambda rows: (-_sum(rows, "arrived"), _sum(rows, "collisions")))
    of_all = _outcome([each for rows in tried.values() for each in rows])
    return [
        f"  {where}: {single[0]['setting']} alone: {_outcome(single)}; all {len(tried)} settings: {of_all}"
    ]


def _outcome(rows: Sequence[Row]) -> str:
    runs, came, touched = (_sum(rows, each) for each in ("runs", "arrived", "collisions"))
    return f"{came} of {runs} arrived, {touched} collided"


def _sum(rows: Sequence[Row], name: str) -> int:
    return int(sum(each[name] for each in rows))


def sound(rows: Sequence[Row]) -> bool:
    """Whether separating lines kept what they promise."""
    return not any(each["collisions"] for each in rows if each["law"] == "gradient + lines")
