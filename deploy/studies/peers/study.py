"""`study peers`: the same scenarios, starts, faults and speed limit under several laws.

ORCA and the barrier-function program are scanned over their parameters in every scenario. Their row shows
the best setting, which favours them. The others have one setting: laws of this software and of the user with
separating lines, the paper's law also without.
"""

from __future__ import annotations

import hashlib
import inspect
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any, Literal

from agents.law.choice import found
from deploy.library.encounters import blocks, boxes, circle, forest, swap
from deploy.library.instances import PAPER_DENSITY, figure_3, random_instance
from deploy.library.load import resolved, try_out
from deploy.studies.peers.contest import Contest, row, sound, summary
from deploy.studies.study import Build, Cell
from protocol.errors import UsageError
from protocol.scenario.model import Control, Scenario
from protocol.scenario.network import Link

Group = Literal["fresh", "late", "RVO2", "boxes"]

LIMIT = 60.0  # s of simulated time
DEADLOCK = 10.0  # s without motion that end a run
DELAYS = (0.0, 0.05, 0.1, 0.2, 0.3)  # s, one way
CROWD_DELAYS = (0.1, 0.3)
DENSITIES = (0.05, PAPER_DENSITY, 0.2)
JITTER = 0.01  # m, so that no start is an exact saddle
CIRCLE_JITTER = 0.5  # m, the same proportion of RVO2's circle


@dataclass(frozen=True)
class Venue:
    """A scenario by seed, with a one-way delay of States, s."""

    name: str
    build: Build
    delay: float = 0.0
    benchmark: Group | None = None  # it belongs to this one, with its lengths, speed, period and limits

    @property
    def label(self) -> str:
        """Name, with the delay if there is one."""
        return f"{self.name}, {1e3 * self.delay:g} ms late" if self.delay else self.name

    @property
    def group(self) -> Group:
        """Group of venues in which the same settings are tried."""
        return self.benchmark or ("late" if self.delay else "fresh")


def places() -> list[Venue]:
    """All venues: tight goal sets, swaps and crowds, also with delays, and benchmarks of others."""
    tight, ten = partial(figure_3, "d"), partial(swap, 10, JITTER)
    late = [Venue(*each, delay) for delay in DELAYS[1:] for each in (("tight 3.30", tight), ("swap 10", ten))]
    return [
        Venue("tight 3.30", tight),
        Venue("tight 3.45", partial(figure_3, "e")),
        Venue("swap 8", partial(swap, 8, JITTER)),
        Venue("swap 10", ten),
        *late,
        Venue("swap 12", partial(swap, 12, JITTER)),
        *(_crowd(12, density) for density in DENSITIES),
        *(_crowd(12, PAPER_DENSITY, delay) for delay in CROWD_DELAYS),
        Venue("swap 24", partial(swap, 24, JITTER)),
        *(_crowd(24, density) for density in DENSITIES),
        *(_crowd(24, PAPER_DENSITY, delay) for delay in CROWD_DELAYS),
        *(Venue(f"Circle {n}", partial(circle, n, CIRCLE_JITTER), benchmark="RVO2") for n in (50, 100, 250)),
        Venue("Blocks", partial(blocks, 100), benchmark="RVO2"),
        Venue("forest 10", partial(forest, 10), benchmark="boxes"),
        Venue("boxes 20", partial(boxes, 20), benchmark="boxes"),
    ]


def _crowd(count: int, density: float, delay: float = 0.0) -> Venue:
    build = partial(random_instance, count, density=density)
    return Venue(f"random {count}, density {density:.2f}", build, delay)


def contest(place: Venue, control: Mapping[str, Any], seed: int) -> Scenario:
    """The scenario of `seed` with these control fields; k and speed are kept."""
    scenario = place.build(seed)
    time = scenario.time if place.benchmark else replace(scenario.time, limit=LIMIT, deadlock=DEADLOCK)
    changed = replace(scenario.control, **control)
    return resolved(replace(scenario, control=changed, link=Link(delay=place.delay), time=time))


RUNS = 20
OTHERS = "deploy.studies.peers.laws"
BARE = Control().without("escape").additions

LAWS: dict[str, dict[str, Any]] = {
    "reciprocal + lines": {"law": "reciprocal", "filter": "separating-lines"},
    "gradient + lines": {"law": "gradient", "filter": "separating-lines"},
    "gradient": {"law": "gradient", "filter": "none", "additions": BARE},
    "orca": {"law": f"{OTHERS}:Orca", "filter": "none"},
    "barrier": {"law": f"{OTHERS}:Barrier", "filter": "none"},
}
# Both methods have the same number of settings. A barrier's gain times the period is at most 1. With late
# States a margin covers the missing motion: up to the distance driven in 150 and in 300 ms; horizon 1 s and
# gain 20/s are left out for more margins. Horizons and gains scale with the time in which a robot moves by
# its radius: 2.5 times that of a swap for RVO2, a third or less among boxes.
Scan = dict[str, tuple[float, ...]]
SCANS: dict[Group, dict[str, Scan]] = {
    "fresh": {
        "orca": {"horizon": (1.0, 2.0, 4.0), "noise": (0.1, 0.3)},
        "barrier": {"gain": (5.0, 10.0, 20.0), "noise": (0.1, 0.6)},
    },
    "late": {
        "orca": {"horizon": (2.0, 4.0), "noise": (0.1, 0.3), "margin": (0.001, 0.005, 0.008, 0.015)},
        "barrier": {"gain": (5.0, 10.0), "noise": (0.1, 0.6), "margin": (0.001, 0.005, 0.01, 0.03)},
    },
    "RVO2": {
        "orca": {"horizon": (2.5, 5.0, 10.0), "noise": (0.1, 0.3)},
        "barrier": {"gain": (1.0, 2.0, 4.0), "noise": (0.1, 0.6)},
    },
    "boxes": {"orca": {"horizon": (0.5, 1.0, 2.0)}, "barrier": {"gain": (1.0, 2.0, 4.0)}},
}
COLUMNS = (
    "scenario law setting runs arrived collisions nrl_mean nrl_error time_mean time_error limit_mean "
    "nrl_ratio time_ratio"
)


def peers(runs: int = RUNS, seed: int = 0, *, laws: Sequence[str] = (), only: Sequence[str] = ()) -> Contest:
    """`runs` runs of every law and setting in all `places`.

    Args:
        laws: the user's, as in `control.law`; they run with separating lines.
        only: texts, one of which a place's label contains; default all places.

    Raises:
        UsageError: a law, a place or a library of a law does not exist.
        LawError: a user's law fails.
    """
    where = _chosen(only)
    own = {f"{law} + lines": {"law": law, "filter": "separating-lines"} for law in laws}
    sources = {name: _source(control["law"]) for name, control in own.items()}
    for control in (LAWS | own).values():
        try_out(contest(where[0], control, seed))
    cells = [
        Cell(
            {"scenario": place.label, "delay": place.delay, "group": place.group, "law": law}
            | setting
            | ({"source": sources[law]} if law in sources else {}),
            partial(contest, place, with_arguments(control, setting)),
            range(seed, seed + runs),
        )
        for place in where
        for law, control in (LAWS | own).items()
        for setting in settings(law, place.group)
    ]
    return Contest("peers", cells, COLUMNS, row, summary, sound)


def _chosen(only: Sequence[str]) -> list[Venue]:
    """Venues selected by `--only`; raises UsageError if there are none."""
    where = places()
    chosen = [place for place in where if not only or any(part in place.label for part in only)]
    if not chosen:
        known = "; ".join(place.label for place in where)
        raise UsageError(f"--only {' --only '.join(only)}: no scenario has this name; there are {known}")
    return chosen


def _source(law: str) -> str:
    """Digest of the source file of a user's law, so that results of other versions are not reused."""
    if ":" not in law:
        raise UsageError(f"--law {law}: name it as module:Class, file.py:Class or entry-point:NAME")
    path = inspect.getsourcefile(found(law)[0])
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()[:16] if path else ""


def settings(law: str, group: Group) -> Iterator[dict[str, float]]:
    """All settings of a law, as arguments of its class."""
    scan = SCANS[group].get(law, {})
    for values in product(*scan.values()):
        yield dict(zip(scan, values, strict=True))


def with_arguments(control: Mapping[str, Any], setting: Mapping[str, float]) -> dict[str, Any]:
    """Control fields, with arguments for the law's class if there are any."""
    arguments = ", ".join(f"{name}={value}" for name, value in setting.items())
    return dict(control) | ({"law": f"{control['law']}({arguments})"} if arguments else {})
