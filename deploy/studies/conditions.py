"""Studies of late, lost and noisy information: `study robustness`, `study delay`, `study arrival`."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from itertools import combinations
from typing import Any, Literal

from deploy.library.encounters import swap
from deploy.library.instances import figure_3, random_robots, workspace_for
from deploy.library.load import resolved
from deploy.run.result import RunResult
from deploy.studies.study import Build, Cell, Row, Study, arrived, error, figures, mean, untouched
from protocol.draws import Purpose, generator
from protocol.scenario.model import Scenario, Sensing, Time, Workspace
from protocol.scenario.network import Link

LIMIT = 120.0  # s of simulated time

# -- robustness: six robots on the tight goal set 3d

DELAYS = (0.0, 0.05, 0.1, 0.2, 0.3, 0.5, 1.0)  # s, one way
LOSSES = (0.0, 0.1, 0.3, 0.5)
NOISES = (0.0005, 0.001, 0.003)  # m, standard deviation, truncated at three of them
PERIODS = (0.02, 0.1, 0.2)  # s
Filter = Literal["separating-lines", "none"]
FILTERS: tuple[Filter, ...] = ("separating-lines", "none")


@dataclass(frozen=True)
class LinkConditions:
    """One point of the grid, s and m. Noise and period are varied around the defaults."""

    delay: float = 0.1
    loss: float = 0.1
    noise: float = 0.0
    period: float = 0.05


def grid() -> Iterator[LinkConditions]:
    """All points: delay by loss, then noise, then period."""
    for delay in DELAYS:
        for loss in LOSSES:
            yield LinkConditions(delay, loss)
    for noise in NOISES:
        yield LinkConditions(noise=noise)
    for period in PERIODS:
        yield LinkConditions(period=period)


def robustness(runs: int = 10, seed: int = 0, conditions: Sequence[LinkConditions] | None = None) -> Study:
    """Effect of delay, loss, noise and period, with separating lines and without a filter.

    Every point has the same `runs` random starts. Delay and loss are crossed; noise and period are varied one
    by one with 100 ms delay and 10 % loss.
    """
    cells = [
        Cell({"filter": filter_, **asdict(point)}, partial(faulty, point, filter_), range(seed, seed + runs))
        for filter_ in FILTERS
        for point in conditions or grid()
    ]
    columns = "filter delay loss noise period runs collisions arrived nrl_mean time_mean min_clearance"
    return Study("robustness", cells, columns, summary=_by_filter, sound=_sound)


def faulty(point: LinkConditions, filter_: Filter, seed: int) -> Scenario:
    """Goal set 3d from the random starts of `seed` under these conditions."""
    scenario = figure_3("d", seed)
    return replace(
        scenario,
        control=replace(scenario.control, filter=filter_),
        time=replace(scenario.time, step=point.period, limit=LIMIT),
        link=Link(delay=point.delay, loss=point.loss),
        sensing=(Sensing(noise=point.noise),),
    )


def _by_filter(rows: Sequence[Row]) -> list[str]:
    lines = []
    for filter_ in FILTERS:
        own = [row for row in rows if row["filter"] == filter_]
        runs, touched = (sum(row[name] for row in own) for name in ("runs", "collisions"))
        came = sum(row["arrived"] for row in own)
        lines.append(f"filter {filter_}: {touched} of {runs} runs collided, {came} arrived")
    return lines


def _sound(rows: Sequence[Row]) -> bool:
    return untouched([row for row in rows if row["filter"] == "separating-lines"])


# -- delay: time lost to late states, for a swap and for tight goals

JITTER = 0.01  # m, of the starts of a swap, since leaving an exact saddle takes extra time
Pace = Literal["common", "own"]
PACES: tuple[Pace, ...] = ("common", "own")
PLACES: dict[str, Build] = {"swap 10": partial(swap, 10, JITTER), "tight 3.30": partial(figure_3, "d")}


class Delays(Study):
    """Adds the ratio of the time to that of the runs without delay."""

    def rows(self, results: Mapping[tuple[int, int], RunResult]) -> list[Row]:
        rows = super().rows(results)
        prompt = {(row["scenario"], row["pace"]): row["times"] for row in rows if row["delay"] == 0.0}
        return [row | against(row["times"], prompt.get((row["scenario"], row["pace"]), {})) for row in rows]


def delay(runs: int = 20, seed: int = 0, delays: Sequence[float] = (0.0, 0.1, 0.3)) -> Study:
    """`runs` starts of both scenarios at both paces; the same starts at each of `delays`, s.

    Every run is compared with that of the same start and pace without delay. The delay is one way and the
    same for all States; there are no other faults.
    """
    cells = [
        Cell(
            {"scenario": name, "pace": pace, "delay": late},
            partial(delayed, build, pace, late),
            range(seed, seed + runs),
        )
        for name, build in PLACES.items()
        for pace in PACES
        for late in delays
    ]
    columns = "scenario pace delay runs collisions arrived nrl_mean time_mean ratio ratio_error"
    return Delays("delay", cells, columns, _with_times, _by_pace, untouched)


def delayed(build: Build, pace: Pace, late: float, seed: int) -> Scenario:
    """The scenario of `seed` at this pace, with States that arrive `late` s old."""
    scenario = build(seed)
    return resolved(
        replace(
            scenario,
            control=scenario.control if pace == "common" else scenario.control.without("pace"),
            link=Link(delay=late),
            time=replace(scenario.time, limit=LIMIT),
        )
    )


def _with_times(labels: Mapping[str, Any], results: Sequence[RunResult]) -> Row:
    times = {str(result["seed"]): result["sim_time"] for result in arrived(results)}
    return {**labels, **figures(results), "times": times}


def against(late: Mapping[str, float], prompt: Mapping[str, float]) -> dict[str, float | None]:
    """Ratio of the mean times of the seeds in both, and its standard error."""
    seeds = [seed for seed in late if seed in prompt]
    base = mean([prompt[seed] for seed in seeds])
    whole = mean([late[seed] for seed in seeds])
    if base is None or whole is None:
        return {"ratio": None, "ratio_error": None}
    ratio = whole / base
    spread = error([late[seed] - ratio * prompt[seed] for seed in seeds])
    return {"ratio": ratio, "ratio_error": None if spread is None else spread / base}


def _by_pace(rows: Sequence[Row]) -> list[str]:
    times = {(row["scenario"], row["delay"], row["pace"]): row["time_mean"] for row in rows}
    lines = []
    for name, late in dict.fromkeys((scenario, late) for scenario, late, _ in times):
        common, own = (times.get((name, late, pace)) for pace in PACES)
        if common is not None and own is not None:
            lines.append(
                f"{name}, {1e3 * late:g} ms: own pace takes {own / common:.2f} of the common pace's time"
            )
    return lines


# -- arrival: arrival of crowds with noisy measurements and late States

DENSITIES = (0.25, 0.33)  # area of all disks over that of the workspace
NOISE = 0.003  # m, standard deviation, truncated at two of them
RADII = (0.02, 0.07)  # m
ROBOTS = (8, 16)
LATEST = 0.5  # s, one-way delay
LOSS = 0.5
TOLERANCE = 0.008  # m
SHRUNK = 0.1  # mean radius of an error set after 100 measurements, over the noise bound


def arrival(runs: int = 100, seed: int = 0) -> Study:
    """`runs` instances at each density; the same with and without noise.

    8 to 16 robots with radii of 0.02 to 0.07 m, random starts and goals, truncated normal noise, States up to
    0.5 s late and up to half of them lost, both random for each instance. An instance is counted if its goals
    leave room for all error sets: sets shrunk by measurements fit around every disk at its goal, beside the
    others and inside the workspace. The tolerance of arrival is not used for that.
    """
    cells = [
        Cell({"noise": noise, "density": density}, partial(crowd, density, noise), range(seed, seed + runs))
        for noise in (NOISE, 0.0)
        for density in DENSITIES
    ]
    columns = "noise density runs collisions room arrived nrl_mean time_mean time_max min_clearance"
    return Study("arrival", cells, columns, _of_those_with_room, _by_noise, untouched)


def crowd(density: float, noise: float, seed: int) -> Scenario:
    """The instance of a seed, with noise of this standard deviation, m."""
    draw = generator(seed, Purpose.STUDY)
    count = int(draw.integers(ROBOTS[0], ROBOTS[1] + 1))
    radii = [round(float(radius), 4) for radius in draw.uniform(*RADII, count)]
    late, loss = (round(float(draw.uniform(0.0, most)), 3) for most in (LATEST, LOSS))
    workspace = workspace_for(radii, density)
    return resolved(
        Scenario(
            random_robots(radii, workspace, seed),
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
    """Smallest room of the goals beyond the error sets, over pairs and wall, m."""
    radii = {spec.id: spec.radius + SHRUNK * scenario.sensing_of(spec.id).bound for spec in scenario.robots}
    beside = (
        math.dist(one.goal, other.goal) - radii[one.id] - radii[other.id]
        for one, other in combinations(scenario.robots, 2)
    )
    inside = (-scenario.workspace.shape.distance(*spec.goal) - radii[spec.id] for spec in scenario.robots)
    return min(*beside, *inside, math.inf)


def _of_those_with_room(labels: Mapping[str, Any], results: Sequence[RunResult]) -> Row:
    scenarios = (crowd(labels["density"], labels["noise"], result["seed"]) for result in results)
    due = [result for result, scenario in zip(results, scenarios, strict=True) if room(scenario) >= 0.0]
    of_due = figures(due)
    return {
        **labels,
        **figures(results),
        **{name: of_due[name] for name in ("arrived", "nrl_mean", "time_mean", "time_max")},
        "room": len(due),
        "times": sorted(result["sim_time"] for result in arrived(due)),
        "missing": [result["seed"] for result in due if result["verdict"] != "arrived"],
    }


def _by_noise(rows: Sequence[Row]) -> list[str]:
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
