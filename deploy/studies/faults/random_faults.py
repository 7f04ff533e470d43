"""`study robustness --random N`: random fault runs; a single collision is a bug, and has a seed."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from deploy.studies.faults.scenario import fault_scenario
from deploy.studies.harness.runners.worker import FAILED
from deploy.studies.harness.statistics import collided, mean
from deploy.studies.harness.study import Cell, Result, Row, Study

COLUMNS = {
    "runs": "d",
    "collisions": "d",
    "arrived": "d",
    "survivors_arrived": "d",
    "barred": "d",
    "not_arrived": "d",
    "failed": "d",
    "nrl_mean": ".3f",
    "time_mean": ".1f",
    "time_max": ".1f",
    "min_clearance": ".2e",
}


def random_faults(runs: int, seed: int = 0) -> Study:
    """`runs` random fault runs from `seed` on; one row that lists the seed of every failure."""
    cell = Cell({"faults": "random"}, fault_scenario, range(seed, seed + runs))
    return Study("robustness", [cell], _row, COLUMNS, _summary, _sound)


def _sound(rows: Sequence[Row]) -> bool:
    return not any(row["collisions"] or row["failed"] for row in rows)


def outcome(result: Result) -> str:
    """What a fault run came to.

    collision; arrived; survivors_arrived: all but robots that were killed; barred: a robot that was
    killed leaves no room; not_arrived; failed: the software did.
    """
    if result["verdict"] == FAILED:
        return "failed"
    if result["collisions"]:
        return "collision"
    if result["verdict"] == "arrived":
        return "arrived"
    if result["down"] and _others_arrived(result):
        return "survivors_arrived"
    return "barred" if result["down"] and _barred(result) else "not_arrived"


def _others_arrived(result: Result) -> bool:
    return set(result["arrived"]) | set(result["down"]) == set(result["robots"])


def _barred(result: Result) -> bool:
    """Whether a dead disk stands on the goal of a robot that is missing, or too near the boundary for it.

    One such robot is enough: it stays in the others' way, and as its gamma does not vanish, their repulsion
    does not either. A disk that a robot cannot pass on the boundary's side is no obstacle of a sphere
    world: it makes a pocket, in which the gradient may end.
    """
    scenario = fault_scenario(result["seed"])
    missing = set(result["robots"]) - set(result["arrived"]) - set(result["down"])
    for dead in map(scenario.spec, result["down"]):
        place = result["positions"][str(dead.id)]
        room = -scenario.workspace.shape.distance(*place) - dead.radius
        for robot in map(scenario.spec, missing):
            if math.dist(place, robot.goal) < robot.radius + dead.radius or room < 2.0 * robot.radius:
                return True
    return False


def _row(labels: Mapping[str, Any], results: Sequence[Result]) -> Row:
    outcomes = [(outcome(result), result) for result in results]
    counts = Counter(kind for kind, _ in outcomes)
    came = [result for kind, result in outcomes if kind in ("arrived", "survivors_arrived")]
    whole = [result for kind, result in outcomes if kind == "arrived"]
    up = [kind for kind, result in outcomes if kind != "failed" and not result["down"]]
    judged = [result for kind, result in outcomes if kind != "failed"]
    return {
        **labels,
        "runs": len(results),
        "collisions": collided(judged),
        "all_up": len(up),
        "all_up_arrived": sum(kind == "arrived" for kind in up),
        "arrived": counts["arrived"],
        "survivors_arrived": counts["survivors_arrived"],
        "barred": counts["barred"],
        "not_arrived": counts["not_arrived"],
        "failed": counts["failed"],
        "nrl_mean": mean([result["nrl"] for result in whole]),
        "time_mean": mean([result["sim_time"] for result in came]),
        "time_max": max((result["sim_time"] for result in came), default=None),
        "min_clearance": min((result["min_clearance"] for result in judged), default=None),
        "barred_seeds": [result["seed"] for kind, result in outcomes if kind == "barred"],
        "failures": [
            {"seed": result["seed"], "outcome": kind, "reason": result["reason"]}
            for kind, result in outcomes
            if kind not in ("arrived", "survivors_arrived", "barred")
        ],
    }


def _summary(rows: Sequence[Row]) -> list[str]:
    """One line, and a command, for every failure."""
    lines = []
    for row in rows:
        due = row["runs"] - row["barred"]
        came = row["arrived"] + row["survivors_arrived"]
        if row["all_up"]:
            arrived, up = row["all_up_arrived"], row["all_up"]
            lines.append(
                f"{arrived} of {up} with nobody down at the end arrived, {100.0 * arrived / up:.2f} %"
            )
        if due:
            lines.append(f"{came} of {due} that could arrive did, {100.0 * came / due:.2f} %")
        lines += [
            f"seed {failure['seed']}: {failure['outcome']}, {failure['reason']}; again with "
            f"disknav study robustness --random 1 --seed {failure['seed']} --fresh"
            for failure in row["failures"]
        ]
    return lines
