"""`study peers`: the same scenarios, faults and speed under other laws.

ORCA and the barrier-function program are tuned by scans (`agents.laws.orca`, `agents.laws.barrier`);
the paper's law runs bare, and with separating lines.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from agents.laws.choice import require
from deploy.library.goal_sets import figure_3
from deploy.library.random_instances import random_instance
from deploy.library.swaps import swap
from deploy.load import resolved
from deploy.studies.statistics import arrived, collided, mean
from deploy.studies.study import Build, Cell, Result, Row, Study
from protocol.scenario import Control, Link, Scenario

RUNS = 5
LIMIT = 120.0  # s of simulated time
DELAYS = (0.0, 0.05, 0.1, 0.2, 0.3)  # s, one way
DENSITIES = (0.1, 0.2, 0.3)
JITTER = 0.005  # m: no law is asked to leave an exact saddle
LAWS: dict[str, dict[str, Any]] = {
    "gradient + lines": {"law": "gradient", "filter": "separating-lines"},
    "gradient": {"law": "gradient", "filter": "none"},
    "orca": {"law": "orca", "filter": "none"},
    "barrier": {"law": "barrier", "filter": "none"},
}
COLUMNS = {
    "scenario": "",
    "delay": "g",
    "law": "",
    "runs": "d",
    "arrived": "d",
    "collisions": "d",
    "nrl_mean": ".3f",
    "time_mean": ".1f",
    "step_us": ".0f",
}


def instances() -> dict[str, Build]:
    """Tight goal sets, swaps and crowds; each a function of the seed."""
    found: dict[str, Build] = {"tight 3.30": partial(figure_3, "d"), "tight 3.45": partial(figure_3, "e")}
    found |= {f"swap {count}": partial(swap, count, JITTER) for count in (8, 12, 24)}
    for count in (12, 24):
        for density in DENSITIES:
            found[f"random {count}, density {density:g}"] = partial(random_instance, count, density=density)
    return found


def peers(
    runs: int = RUNS,
    seed: int = 0,
    scenarios: Mapping[str, Build] | None = None,
    delays: Sequence[float] = DELAYS,
) -> Study:
    """`runs` runs of every scenario at every delay under every law.

    Raises:
        UsageError: a law's library is not installed.
    """
    for control in LAWS.values():
        require(control["law"])
    cells = [
        Cell({"scenario": name, "delay": delay, "law": law}, partial(contest, build, delay, law), seeds)
        for name, build in (instances() if scenarios is None else scenarios).items()
        for delay in delays
        for law in LAWS
        for seeds in [range(seed, seed + runs)]
    ]
    return Study("peers", cells, _row, COLUMNS, _summary, _sound)


def contest(build: Build, delay: float, law: str, seed: int) -> Scenario:
    """One scenario under one law and delay."""
    scenario = resolved(build(seed))
    control: Control = replace(scenario.control, **LAWS[law])
    return replace(
        scenario, control=control, link=Link(delay=delay), time=replace(scenario.time, limit=LIMIT)
    )


def _row(labels: Mapping[str, Any], results: Sequence[Result]) -> Row:
    """step: CPU of a robot and tick, its share of world and messages included."""
    came = arrived(results)
    return {
        **labels,
        "runs": len(results),
        "arrived": len(came),
        "collisions": collided(results),
        "nrl_mean": mean([result["nrl"] for result in came]),
        "time_mean": mean([result["sim_time"] for result in came]),
        "step_us": mean(
            [1e6 * r["cpu_s"] / r["ticks"] / len(r["robots"]) for r in results if "cpu_s" in r and r["ticks"]]
        ),
    }


def _summary(rows: Sequence[Row]) -> list[str]:
    lines = []
    for law in LAWS:
        own = [row for row in rows if row["law"] == law]
        runs, came, touched = (sum(row[name] for row in own) for name in ("runs", "arrived", "collisions"))
        lines.append(f"{law}: {came} of {runs} arrived, {touched} collided")
    return lines


def _sound(rows: Sequence[Row]) -> bool:
    return not any(row["collisions"] for row in rows if row["law"] == "gradient + lines")
