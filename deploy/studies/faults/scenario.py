"""Random fault runs: everything that may go wrong at once, drawn from one seed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from deploy.library.load import resolved
from deploy.library.random_instances import random_instance
from protocol.draws import Purpose, generator
from protocol.scenario.model import Link, Partition, ProcessFault, Scenario, Sensing

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
