"""`study peers`: the same scenarios, starts, faults and speed limit under other laws.

ORCA and the barrier-function program are scanned over their parameters in every scenario, and the best
setting is what a law's row shows, which favours them; the paper's law runs bare, and with separating lines.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import Any

from agents.laws.choice import require
from deploy.library.goal_sets import figure_3
from deploy.library.load import resolved
from deploy.library.random_instances import PAPER_DENSITY, random_instance
from deploy.library.swaps import swap
from deploy.studies.peers.contest import Contest, row, sound, summary
from deploy.studies.study import Build, Cell
from protocol.scenario.model import Link, Scenario

RUNS = 5
LIMIT = 60.0  # s of simulated time
DEADLOCK = 10.0  # s without anybody moving
DELAYS = (0.0, 0.05, 0.1, 0.2, 0.3)  # s, one way
DENSITIES = (0.05, PAPER_DENSITY, 0.2)
JITTER = 0.01  # m: no law is asked to leave an exact saddle

LAWS: dict[str, dict[str, Any]] = {
    "gradient + lines": {"law": "gradient", "filter": "separating-lines"},
    "gradient": {"law": "gradient", "filter": "none", "escape": False},
    "orca": {"law": "orca", "filter": "none"},
    "barrier": {"law": "barrier", "filter": "none"},
}
NAMES = {  # of the laws, for people
    "gradient + lines": "separating lines",
    "gradient": "bare law",
    "orca": "ORCA",
    "barrier": "barrier QP",
}
# As many settings for either method. A barrier's gain times the period is at most 1.
Scan = dict[str, tuple[float, ...]]
SCANS: dict[str, Scan] = {
    "orca": {"horizon": (1.0, 2.0, 4.0), "symmetry_noise": (0.1, 0.3)},
    "barrier": {"barrier_gain": (5.0, 10.0, 20.0), "symmetry_noise": (0.1, 0.6)},
}
# Where states are delayed a margin has to cover what they miss: in m, up to what a robot drives in 150 and
# in 300 ms. Horizon 1 s and gain 20 per s are left out here for the sake of more margins.
LATE_SCANS: dict[str, Scan] = {
    "orca": {
        "horizon": (2.0, 4.0),
        "symmetry_noise": (0.1, 0.3),
        "margin": (0.001, 0.005, 0.008, 0.015),
    },
    "barrier": {
        "barrier_gain": (5.0, 10.0),
        "symmetry_noise": (0.1, 0.6),
        "margin": (0.001, 0.005, 0.01, 0.03),
    },
}
COLUMNS = {
    "scenario": "",
    "law": "",
    "setting": "",
    "runs": "d",
    "arrived": "d",
    "collisions": "d",
    "nrl_mean": ".3f",
    "time_mean": ".1f",
    "step_us": ".0f",
}


@dataclass(frozen=True)
class Place:
    """Where laws meet: a scenario of a seed, and the one-way delay of states in it, s."""

    name: str
    build: Build
    delay: float = 0.0

    @property
    def label(self) -> str:
        """The name, with the delay if there is one."""
        return f"{self.name}, {1e3 * self.delay:g} ms late" if self.delay else self.name


def places() -> list[Place]:
    """Tight goal sets and swaps, also with delays; crowds; the largest last."""
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
        Place("swap 24", partial(swap, 24, JITTER)),
        *(_crowd(24, density) for density in DENSITIES),
    ]


def _crowd(count: int, density: float) -> Place:
    return Place(f"random {count}, density {density:.2f}", partial(_random, count, density))


def _random(count: int, density: float, seed: int) -> Scenario:
    return random_instance(count, seed, density=density)


def peers(
    runs: int = RUNS,
    seed: int = 0,
    scenarios: Mapping[str, Build] | None = None,
    delays: Sequence[float] = DELAYS,
) -> Contest:
    """`runs` runs of every law and setting in all `places`, or in `scenarios` at every delay.

    Raises:
        UsageError: a law's library is not installed.
    """
    for control in LAWS.values():
        require(control["law"])
    if scenarios is None:
        where = places()
    else:
        where = [Place(name, build, delay) for name, build in scenarios.items() for delay in delays]
    cells = [
        Cell(
            {"scenario": place.label, "delay": place.delay, "law": law, **setting},
            partial(contest, place, LAWS[law] | setting),
            range(seed, seed + runs),
        )
        for place in where
        for law in LAWS
        for setting in settings(law, late=place.delay > 0.0)
    ]
    return Contest("peers", cells, row, COLUMNS, summary, sound)


def settings(law: str, *, late: bool) -> Iterator[dict[str, float]]:
    """Everything that is tried with a law, as fields of `protocol.scenario.model.Control`."""
    scan = (LATE_SCANS if late else SCANS).get(law, {})
    for values in product(*scan.values()):
        yield dict(zip(scan, values, strict=True))


def contest(place: Place, control: Mapping[str, Any], seed: int) -> Scenario:
    """The scenario of `seed` with these fields of its control table; k and speed stay."""
    scenario = place.build(seed)
    return resolved(
        replace(
            scenario,
            control=replace(scenario.control, **control),
            link=Link(delay=place.delay),
            time=replace(scenario.time, limit=LIMIT, deadlock=DEADLOCK),
        )
    )
