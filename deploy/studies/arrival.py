"""`study arrival`: whether crowds arrive whose robots know their own places badly, and each other late.

8 to 16 robots, radii of 0.02 to 0.07 m, random starts and goals; measurements with truncated normal
noise, and the same instances without; states up to 0.5 s late, up to half of them lost, both drawn anew for
each instance. An instance counts if its goals leave room for all error sets: the radius to which such sets
shrink fits around every disk at its goal, beside the others' and inside the workspace. No use is made of
the tolerance by which a robot may be off its goal.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from itertools import combinations
from typing import Any

import numpy as np

from deploy.library.load import resolved
from deploy.library.random_instances import random_starts
from deploy.studies.study import Cell, Result, Row, Study, arrived, collided, mean, untouched
from protocol.draws import Purpose, generator
from protocol.scenario.model import Link, RobotSpec, Scenario, Sensing, Time, Workspace

RUNS = 100
DENSITIES = (0.25, 0.33)  # area of all disks over that of the workspace
NOISES = (0.003, 0.0)  # m, standard deviation, truncated at two of them
RADII = (0.02, 0.07)  # m
ROBOTS = (8, 16)
LATEST = 0.5  # s, one-way delay
LOSS = 0.5
TOLERANCE = 0.008  # m
LIMIT = 120.0  # s of simulated time
SHRUNK = 0.1  # radius of a set after 100 measurements, mean, over the noise bound
COLUMNS = {
    "noise": "g",
    "density": "g",
    "runs": "d",
    "collisions": "d",
    "room": "d",
    "arrived": "d",
    "nrl_mean": ".3f",
    "time_mean": ".1f",
    "time_max": ".1f",
    "min_clearance": ".2e",
}


def arrival(runs: int = RUNS, seed: int = 0) -> Study:
    """`runs` instances at each density; the same with and without noise."""
    cells = [
        Cell({"noise": noise, "density": density}, partial(crowd, density, noise), range(seed, seed + runs))
        for noise in NOISES
        for density in DENSITIES
    ]
    return Study("arrival", cells, _row, COLUMNS, _summary, untouched)


def crowd(density: float, noise: float, seed: int) -> Scenario:
    """The instance of a seed, with measurements of this noise, m."""
    draw = generator(seed, Purpose.STUDY)
    count = int(draw.integers(ROBOTS[0], ROBOTS[1] + 1))
    radii = [round(float(radius), 4) for radius in draw.uniform(*RADII, count)]
    late, loss = (round(float(draw.uniform(0.0, most)), 3) for most in (LATEST, LOSS))
    workspace = round(float(np.sqrt((np.array(radii) ** 2).sum() / density)) + 5e-7, 6)
    starts, goals = (random_starts(radii, workspace, seed, stream) for stream in (0, 1))
    robots = tuple(
        RobotSpec(n + 1, radius, start, goal)
        for n, (radius, start, goal) in enumerate(zip(radii, starts, goals, strict=True))
    )
    return resolved(
        Scenario(
            robots,
            "crowd",
            f"{count} unequal robots, density {density:g}, random starts and goals",
            seed,
            Workspace(workspace),
            Time(limit=LIMIT, tolerance=TOLERANCE),
            sensing=(Sensing(noise=noise, noise_bound=2.0 * noise),),
            link=Link(delay=(0.0, late), loss=loss),
        )
    )


def room(scenario: Scenario) -> float:
    """By how much the goals leave more room than the error sets need, the least over pairs and wall, m."""
    radii = {spec.id: spec.radius + SHRUNK * scenario.sensing_of(spec.id).bound for spec in scenario.robots}
    beside = (
        math.dist(one.goal, other.goal) - radii[one.id] - radii[other.id]
        for one, other in combinations(scenario.robots, 2)
    )
    inside = (-scenario.workspace.shape.distance(*spec.goal) - radii[spec.id] for spec in scenario.robots)
    return min(*beside, *inside, math.inf)


def _row(labels: Mapping[str, Any], results: Sequence[Result]) -> Row:
    scenarios = (crowd(labels["density"], labels["noise"], result["seed"]) for result in results)
    due = [result for result, scenario in zip(results, scenarios, strict=True) if room(scenario) >= 0.0]
    came = arrived(due)
    return {
        **labels,
        "runs": len(results),
        "collisions": collided(results),
        "room": len(due),
        "arrived": len(came),
        "nrl_mean": mean([result["nrl"] for result in came]),
        "time_mean": mean([result["sim_time"] for result in came]),
        "time_max": max((result["sim_time"] for result in came), default=None),
        "min_clearance": min(result["min_clearance"] for result in results),
        "times": sorted(result["sim_time"] for result in came),
        "missing": [result["seed"] for result in due if result["verdict"] != "arrived"],
    }


def _summary(rows: Sequence[Row]) -> list[str]:
    lines = []
    for noise in sorted({row["noise"] for row in rows}):
        own = [row for row in rows if row["noise"] == noise]
        due, came = (sum(row[name] for row in own) for name in ("room", "arrived"))
        if due:
            what = f"noise {1e3 * noise:g} mm, bound {2e3 * noise:g} mm" if noise else "without noise"
            lines.append(
                f"{what}: {came} of {due} whose goals leave room arrived, {100.0 * came / due:.1f} %"
            )
        lines += [
            f"density {row['density']:g}, noise {row['noise']:g}: seed {seed} did not arrive"
            for row in own
            for seed in row["missing"]
        ]
    return lines
