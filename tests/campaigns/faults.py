"""Random faults: everything that may go wrong at once; a single collision is a bug, and has a seed."""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from deploy.library.instances import random_instance
from deploy.library.load import resolved
from deploy.run.local import LocalFleet
from protocol.draws import Purpose, generator
from protocol.scenario.file import write_toml
from protocol.scenario.model import ProcessFault, Scenario, Sensing
from protocol.scenario.network import Link, Partition
from tests.campaigns.campaign import Campaign, Dice, Outcome

LIMIT = 120.0  # s of simulated time
_UNEQUAL = 0.4  # spread of unequal radii


def fault_scenario(seed: int) -> Scenario:
    """3 to 8 robots at the paper's density, random starts and goals, a bad network, and often more.

    Always: one-way delays uniform in 0 to 1 s, half of all States lost. Each with a probability of its
    own: unequal radii, sensing faults, duplicates, a partition, a process fault.
    """
    draw = generator(seed, Purpose.STUDY)
    count = int(draw.integers(3, 9))
    unequal = _UNEQUAL if draw.random() < 0.5 else 0.0
    instance = resolved(random_instance(count, seed, unequal=unequal, name="fault-run"))
    return replace(
        instance,
        description="random faults",
        time=replace(instance.time, limit=LIMIT),
        link=_link(draw, count),
        sensing=_sensing(draw),
        process=_process(draw, count),
    )


def _link(draw: np.random.Generator, count: int) -> Link:
    duplicate = 0.2 if draw.random() < 0.5 else 0.0
    partition = (_partition(draw, count),) if draw.random() < 0.3 else ()
    return Link(delay=(0.0, 1.0), loss=0.5, duplicate=duplicate, partition=partition)


def _partition(draw: np.random.Generator, count: int) -> Partition:
    """Two random groups that do not hear each other for a while."""
    robots = [int(robot) for robot in draw.permutation(count) + 1]
    cut = int(draw.integers(1, count))
    begin = round(float(draw.uniform(0.0, 5.0)), 2)
    end = round(begin + float(draw.uniform(0.5, 3.0)), 2)
    return Partition(begin, end, (tuple(sorted(robots[:cut])), tuple(sorted(robots[cut:]))))


def _sensing(draw: np.random.Generator) -> tuple[Sensing, ...]:
    if draw.random() < 0.5:
        return (Sensing(),)
    bias = (round(float(draw.uniform(-1e-3, 1e-3)), 6), 0.0) if draw.random() < 0.3 else (0.0, 0.0)
    return (Sensing(delay=(0.0, 0.3), noise=0.001, noise_bound=0.003, bias=bias, dropout=0.1),)


def _process(draw: np.random.Generator, count: int) -> tuple[ProcessFault, ...]:
    """Half of the runs have none; else a robot or two are killed for good, restarted, or frozen a while."""
    kind = draw.choice(["none", "kill", "pause", "restart", "both"], p=[0.5, 0.1, 0.15, 0.15, 0.1])
    first, second = (int(robot) for robot in draw.permutation(count)[:2] + 1)
    at = round(float(draw.uniform(0.0, 4.0)), 2)
    later = round(at + float(draw.uniform(0.1, 4.0)), 2)
    faults = {
        "none": (),
        "kill": (ProcessFault(first, at, "kill"),),
        "pause": (ProcessFault(first, at, "pause"), ProcessFault(first, later, "resume")),
        "restart": (ProcessFault(first, at, "restart"),),
        "both": (ProcessFault(first, at, "restart"), ProcessFault(second, later, "restart")),
    }
    return faults[str(kind)]


def run(dice: Dice) -> Outcome:
    """One run.

    It ends as collision; arrived; survivors arrived: all but robots that were killed; barred: a robot that
    was killed leaves no room; or not arrived. "all up" counts the runs at whose end no robot was down.
    """
    scenario = fault_scenario(dice.seed)
    report = LocalFleet(scenario).execute()
    missing = set(scenario.ids) - set(report["arrived"]) - set(report["down"])
    if report["collisions"]:
        said = "collision"
    elif report["verdict"] == "arrived":
        said = "arrived"
    elif report["down"] and not missing:
        said = "survivors arrived"
    else:
        said = "barred" if barred(scenario, report, missing) else "not arrived"
    figures = {"clearance, m": report["min_clearance"], "all up": float(not report["down"])}
    violation = f"collision: {report['contacts'][:1]}" if report["collisions"] else ""
    return Outcome(said, violation, write_toml(scenario) if violation else "", figures)


def barred(scenario: Scenario, report: Mapping[str, Any], missing: set[int]) -> bool:
    """Whether a dead disk stands on the goal of a robot that is missing, or too near the boundary for it.

    One such robot is enough: it stays in the others' way, and as its gamma does not vanish, their repulsion
    does not either. A disk that a robot cannot pass on the boundary's side is no obstacle of a sphere
    world: it makes a pocket, in which the gradient may end.
    """
    for dead in map(scenario.spec, report["down"]):
        place = report["positions"][str(dead.id)]
        room = -scenario.workspace.shape.distance(*place) - dead.radius
        for robot in map(scenario.spec, missing):
            if math.dist(place, robot.goal) < robot.radius + dead.radius or room < 2.0 * robot.radius:
                return True
    return False


FAULTS = Campaign(run, 10_000)
