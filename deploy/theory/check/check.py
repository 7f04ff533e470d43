"""The report of `disknav check`: the theory for a scenario, and what is seen in practice at the k in use."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from deploy.theory.assumptions import Margins, Status, first_status, margins, second_status
from deploy.theory.bounds import Bounds, best_bounds
from deploy.theory.configurations import mirrored_triples, random_configuration
from deploy.theory.equilibria import CriticalPoint, classify, equilibria, find_equilibrium, swapped_pairs
from deploy.theory.exact_flow import FlowResult, integrate
from deploy.theory.function import Array, Problem, displacements, in_free_space
from deploy.theory.tuning import automatic_k, density
from protocol.draws import Purpose, generator
from protocol.scenario.model import Scenario
from world.judge.clearance import Disks
from world.judge.measures import Goals, tight

LARGEST = 32  # robots
SEARCHED = 12  # robots up to which equilibria are looked for
RANDOM_STARTS = 10


@dataclass(frozen=True)
class Practice:
    """arrived, nrl, rest: from the scenario's own start; the random starts are drawn from its seed.

    rest: the kind of equilibrium at which that start comes to rest, None when it arrives or nowhere rests.

    equilibria: how many were found of each kind, such as "saddle of index 2", the goal left out; empty
    when they were not looked for. other_minima: equilibria besides the goal that attract.
    """

    arrived: bool
    nrl: float
    rest: str | None
    random_starts: int
    random_arrived: int
    searched: bool
    equilibria: dict[str, int]
    other_minima: int


def practice(problem: Problem, start: Array, seed: int) -> Practice | None:
    """Follow the flow and look for equilibria; None beyond 32 robots or when start or goal is not free."""
    if problem.p > LARGEST or not (in_free_space(problem, start) and in_free_space(problem, problem.goals)):
        return None
    starts = _random_starts(problem, seed)
    own, others = integrate(problem, start), [integrate(problem, b) for b in starts]
    searched = problem.p <= SEARCHED
    kinds = _kinds(problem, [own, *others], starts) if searched else Counter()
    arrived = sum(flow.arrived for flow in others)
    rest = None if own.arrived else _rest(problem, own)
    return Practice(own.arrived, own.nrl, rest, len(starts), arrived, searched, dict(kinds), kinds["minimum"])


def _rest(problem: Problem, flow: FlowResult) -> str | None:
    b = find_equilibrium(problem, flow.path[-1])
    return None if b is None else _name(classify(problem, b))


def _random_starts(problem: Problem, seed: int) -> list[Array]:
    draw = generator(seed, Purpose.STUDY)
    count = RANDOM_STARTS if problem.p <= SEARCHED else 2
    drawn = (random_configuration(draw, problem.radii, problem.workspace) for _ in range(count))
    return [b for b in drawn if b is not None]


def _kinds(problem: Problem, flows: list[FlowResult], starts: list[Array]) -> Counter[str]:
    """Equilibria reached from the ends of failed flows, from blocked pairs and from the random starts."""
    ends = [flow.path[-1] for flow in flows if not flow.arrived]
    refined = [b for end in ends if (b := find_equilibrium(problem, end)) is not None]
    found = equilibria(problem, [*refined, *swapped_pairs(problem), *starts])[1:]
    return Counter(_name(point) for point in found)


def _name(point: CriticalPoint) -> str:
    return f"saddle of index {point.index}" if point.kind == "saddle" else point.kind


@dataclass(frozen=True)
class Free:
    """Whether a configuration is free, and its smallest clearance, m (negative is overlap)."""

    free: bool
    clearance: float


@dataclass(frozen=True)
class Shortfall:
    """A cluster for which an assumption is not shown. Ids, None when it stands for all clusters of its size.

    margin: left-hand side minus right-hand side, m, not positive.
    """

    robots: tuple[int, ...] | None
    size: int
    margin: float
    status: Status


@dataclass(frozen=True)
class Assumption:
    """One assumption over all clusters, in the limit of small eps; worst: the smallest margin, m."""

    status: Status
    worst: float
    clusters: int
    failing: int
    shortfalls: tuple[Shortfall, ...]  # smallest clusters first, then the widest gap; at most LISTED


@dataclass(frozen=True)
class Certified:
    """What a stored certificate proves, None when nothing yet, or why it was refused."""

    file: str
    k: float | None
    refused: str | None = None


@dataclass(frozen=True)
class CheckReport:
    """Everything `disknav check` says. Lengths in m, eps in m^2.

    exact: every cluster was looked at and Lambda', Lambda'' are attained; else they are proven upper bounds.
    bounds: at the best eps, None where the assumptions are not shown.
    """

    scenario: str
    robots: int
    density: float
    tight: float | None
    k: float
    automatic: bool
    automatic_k: float
    start: Free
    goal: Free
    unreachable: tuple[tuple[int, int, int], ...]
    every_cluster: bool
    exact: bool
    assumption_1: Assumption
    assumption_2: Assumption
    bounds: Bounds | None
    practice: Practice | None
    certificate: Certified | None

    @property
    def guaranteed(self) -> bool:
        """Whether the theory covers the k in use."""
        return self.bounds is not None and self.k > self.bounds.polar


def to_json(found: CheckReport) -> dict[str, Any]:
    """Plain data; an infinite number becomes None, since JSON has none."""
    plain = finite(asdict(found)) | {"guaranteed": found.guaranteed}
    if found.bounds is not None:
        plain["bounds"] |= {"k2": found.bounds.k2, "polar": found.bounds.polar}
    return dict(plain)


def finite(value: Any) -> Any:
    """Plain data with None for every number that is not finite."""
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


LISTED = 5  # shortfalls that are spelled out


def report(scenario: Scenario, certificate: Certified | None = None) -> CheckReport:
    """Evaluate the theory for a valid scenario, and follow the exact flow from some starts.

    Takes from milliseconds to a few seconds; the part about practice is left out beyond 32 robots.
    """
    problem, start, ids = _problem(scenario)
    found = margins(problem, 0.0)
    several = np.flatnonzero(found.clusters.sizes >= 2)
    return CheckReport(
        scenario=scenario.name,
        robots=problem.p,
        density=density(problem.radii, problem.workspace),
        tight=tight(Disks.of(scenario), Goals.of(scenario)),
        k=problem.k,
        automatic=scenario.control.k == "auto",
        automatic_k=automatic_k(problem.radii, problem.workspace),
        start=_free(problem, start),
        goal=_free(problem, problem.goals),
        unreachable=tuple((ids[i], ids[j], ids[k]) for i, j, k in mirrored_triples(problem, start)),
        every_cluster=found.clusters.enumerated,
        exact=bool(found.stretch.exact[several].all()),
        assumption_1=_assumption(
            ids, found, found.first, several, lambda row: first_status(problem, found, row, 0.0)
        ),
        assumption_2=_assumption(ids, found, found.second, several, lambda row: second_status(found, row)),
        bounds=best_bounds(problem),
        practice=practice(problem, start, scenario.seed),
        certificate=certificate,
    )


def _problem(scenario: Scenario) -> tuple[Problem, Array, tuple[int, ...]]:
    """The problem, the start, and robot ids, all in order of id."""
    specs = [scenario.spec(robot) for robot in scenario.ids]
    radii = np.array([spec.radius for spec in specs])
    workspace, k = scenario.workspace.disk_radius, scenario.control.k
    gain = automatic_k(radii, workspace) if isinstance(k, str) else k
    goals, start = (np.array([getattr(spec, name) for spec in specs], dtype=np.float64) for name in _ENDS)
    return Problem(goals, radii, workspace, gain), start, scenario.ids


_ENDS = ("goal", "start")


def _free(problem: Problem, b: Array) -> Free:
    gaps = np.linalg.norm(displacements(b), axis=2) - problem.contact
    np.fill_diagonal(gaps, np.inf)
    rim = problem.reach - np.linalg.norm(b, axis=1)
    return Free(in_free_space(problem, b), float(min(gaps.min(), rim.min())))


def _assumption(
    ids: tuple[int, ...],
    found: Margins,
    values: Array,
    rows: np.ndarray[Any, np.dtype[np.intp]],
    status: Callable[[int], Status],
) -> Assumption:
    failing = [int(row) for row in rows if not values[row] > 0.0]
    failing.sort(key=lambda row: (found.clusters.sizes[row], values[row]))
    states = [status(row) for row in failing]
    listed = [
        Shortfall(_names(ids, found, row), int(found.clusters.sizes[row]), float(values[row]), state)
        for row, state in zip(failing[:LISTED], states[:LISTED], strict=True)
    ]
    overall: Status = "violated" if "violated" in states else "not shown" if states else "holds"
    worst = float(values[rows].min()) if len(rows) else float("inf")
    return Assumption(overall, worst, len(rows), len(failing), tuple(listed))


def _names(ids: tuple[int, ...], found: Margins, row: int) -> tuple[int, ...] | None:
    members = found.clusters.names(row)
    return None if members is None else tuple(ids[i] for i in members)
