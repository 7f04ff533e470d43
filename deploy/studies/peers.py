"""`study peers`: separating lines beside ORCA, a barrier-function QP and the paper's bare law.

The same scenarios, starts, faults and speed limit. The parameters of ORCA and of the barriers are
scanned in every scenario, and the best of all settings is what its row shows, which favours them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from itertools import product

from agents.laws import require
from deploy.library.goal_sets import figure_3
from deploy.library.random_instances import PAPER_DENSITY, random_instance
from deploy.library.swaps import swap
from deploy.load import resolved
from deploy.studies.contest import Contest, row
from deploy.studies.study import Build, Cell
from protocol.scenario import Control, Link, Scenario

RUNS = 5
LIMIT = 60.0  # s of simulated time
DEADLOCK = 10.0  # s without anybody moving
JITTER = 0.01  # m, of the starts of a swap
DELAYS = (0.0, 0.05, 0.1, 0.2, 0.3)  # s, one way
DENSITIES = (0.05, PAPER_DENSITY, 0.2)

HORIZONS = (1.0, 2.0, 4.0)  # s
GAINS = (1.0, 3.0, 10.0)  # 1/s
NOISES = (0.0, 0.1)
MARGINS = (0.01, 0.1)  # tried where states are late; elsewhere the small one

COLUMNS = {
    "scenario": "",
    "delay": "g",
    "law": "",
    "setting": "",
    "runs": "d",
    "arrived": "d",
    "collisions": "d",
    "nrl_mean": ".3f",
    "time_mean": ".1f",
    "step_us": ".0f",
}

Settings = dict[str, float]
Place = tuple[str, float, Build]  # name, delay, what gives the scenario of a seed


def peers(
    runs: int = RUNS, seed: int = 0, places: Sequence[Place] | None = None, scan: bool = True
) -> Contest:
    """`runs` seeds in each of `places` (all, unless given) under every law and setting.

    Raises:
        UsageError: a law's library is not installed.
    """
    for law in ("orca", "barrier"):
        require(law)
    seeds = range(seed, seed + runs)
    cells = [
        _cell(place, law, control, settings, seeds)
        for place in (all_places() if places is None else places)
        for law, control, settings in contenders(place[1] > 0.0, scan)
    ]
    return Contest("peers", cells, row, COLUMNS)


def all_places() -> list[Place]:
    """Every scenario, with its delay in s."""
    places: list[Place] = [
        ("tight 3.30", 0.0, partial(figure_3, "d")),
        ("tight 3.45", 0.0, partial(figure_3, "e")),
    ]
    places += [(f"swap {count}", 0.0, partial(swap, count, JITTER)) for count in (8, 12, 24)]
    places += [
        (f"random {count}, density {density:.2f}", 0.0, partial(_random, count, density))
        for count in (12, 24)
        for density in DENSITIES
    ]
    places += [("swap 10", delay, partial(swap, 10, JITTER)) for delay in DELAYS]
    places += [("tight 3.30", delay, partial(figure_3, "d")) for delay in DELAYS if delay > 0.0]
    return places


def contenders(late: bool, scan: bool = True) -> list[tuple[str, Control, Settings]]:
    """Name, control and what is scanned; `late`: whether states are delayed, so that margins may help."""
    noises, margins = NOISES, MARGINS[:1]
    if late:
        noises, margins = NOISES[-1:], MARGINS
    bare = Control(filter="none")
    found: list[tuple[str, Control, Settings]] = [
        ("separating lines", Control(filter="separating-lines"), {}),
        ("bare law", bare, {}),
    ]
    for horizon, noise, margin in product(HORIZONS, noises, margins):
        settings = {"horizon": horizon, "symmetry_noise": noise, "margin": margin}
        found.append(("ORCA", replace(bare, law="orca"), settings))
    for gain, noise, margin in product(GAINS, noises, margins):
        settings = {"barrier_gain": gain, "symmetry_noise": noise, "margin": margin}
        found.append(("barrier QP", replace(bare, law="barrier"), settings))
    if scan:
        return found
    return list({name: (name, control, settings) for name, control, settings in found}.values())


def contest(build: Build, delay: float, control: Control, settings: Settings, seed: int) -> Scenario:
    """The scenario of `seed` under this law; k and speed stay the scenario's."""
    scenario = build(seed)
    law = replace(scenario.control, law=control.law, filter=control.filter, **settings)  # type: ignore[arg-type]
    time = replace(scenario.time, limit=LIMIT, deadlock=DEADLOCK)
    return resolved(replace(scenario, control=law, time=time, link=Link(delay=delay)))


def _random(count: int, density: float, seed: int) -> Scenario:
    return random_instance(count, seed, density=density)


def _cell(place: Place, law: str, control: Control, settings: Settings, seeds: Sequence[int]) -> Cell:
    name, delay, build = place
    labels = {"scenario": name, "delay": delay, "law": law, **settings}
    return Cell(labels, partial(contest, build, delay, control, settings), seeds)
