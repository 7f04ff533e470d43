"""Where laws meet: scenarios, starts drawn from a seed, and how late states are there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal

from deploy.library.among_things import blocks, boxes, forest
from deploy.library.figures import figure_3
from deploy.library.load import resolved
from deploy.library.random_instances import PAPER_DENSITY, random_instance
from deploy.library.swaps import circle, swap
from deploy.studies.study import Build
from protocol.scenario.model import Link, Scenario

Group = Literal["fresh", "late", "RVO2", "boxes"]

LIMIT = 60.0  # s of simulated time
DEADLOCK = 10.0  # s in which no robot moves
DELAYS = (0.0, 0.05, 0.1, 0.2, 0.3)  # s, one way
CROWD_DELAYS = (0.1, 0.3)
DENSITIES = (0.05, PAPER_DENSITY, 0.2)
JITTER = 0.01  # m: no law is asked to leave an exact saddle
CIRCLE_JITTER = 0.5  # m, the same in proportion on RVO2's circle


@dataclass(frozen=True)
class Place:
    """A scenario of a seed, and the one-way delay of states in it, s.

    foreign: of which benchmarks of others it is, with its own lengths, speed, period and limits.
    """

    name: str
    build: Build
    delay: float = 0.0
    foreign: Group | None = None

    @property
    def label(self) -> str:
        """The name, with the delay if there is one."""
        return f"{self.name}, {1e3 * self.delay:g} ms late" if self.delay else self.name

    @property
    def group(self) -> Group:
        """Places in which the same settings are tried."""
        return self.foreign or ("late" if self.delay else "fresh")


def places() -> list[Place]:
    """Tight goal sets, swaps and crowds, also with delays; the largest and those of others last."""
    tight, ten = partial(figure_3, "d"), partial(swap, 10, JITTER)
    late = [Place(*each, delay) for delay in DELAYS[1:] for each in (("tight 3.30", tight), ("swap 10", ten))]
    return [
        Place("tight 3.30", tight),
        Place("tight 3.45", partial(figure_3, "e")),
        Place("swap 8", partial(swap, 8, JITTER)),
        Place("swap 10", ten),
        *late,
        Place("swap 12", partial(swap, 12, JITTER)),
        *(_crowd(12, density) for density in DENSITIES),
        *(_crowd(12, PAPER_DENSITY, delay) for delay in CROWD_DELAYS),
        Place("swap 24", partial(swap, 24, JITTER)),
        *(_crowd(24, density) for density in DENSITIES),
        *(_crowd(24, PAPER_DENSITY, delay) for delay in CROWD_DELAYS),
        *(Place(f"Circle {n}", partial(circle, n, CIRCLE_JITTER), foreign="RVO2") for n in (50, 100, 250)),
        Place("Blocks", partial(blocks, 100), foreign="RVO2"),
        Place("forest 10", partial(forest, 10), foreign="boxes"),
        Place("boxes 20", partial(boxes, 20), foreign="boxes"),
    ]


def _crowd(count: int, density: float, delay: float = 0.0) -> Place:
    return Place(f"random {count}, density {density:.2f}", partial(_random, count, density), delay)


def _random(count: int, density: float, seed: int) -> Scenario:
    return random_instance(count, seed, density=density)


def contest(place: Place, control: Mapping[str, Any], seed: int) -> Scenario:
    """The scenario of `seed` with these fields of its control table; k and speed stay."""
    scenario = place.build(seed)
    time = scenario.time if place.foreign else replace(scenario.time, limit=LIMIT, deadlock=DEADLOCK)
    changed = replace(scenario.control, **control)
    return resolved(replace(scenario, control=changed, link=Link(delay=place.delay), time=time))
