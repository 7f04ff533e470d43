"""`disknav check`: evaluates the theory for a scenario, and looks at what is seen in practice."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from deploy.theory.check.practice import practice
from deploy.theory.check.report import Assumption, Certified, CheckReport, Free, Shortfall
from deploy.theory.function import Array, Problem, displacements, in_free_space
from deploy.theory.gain.assumptions import Margins, Status, first_status, margins, second_status
from deploy.theory.gain.best_bound import best_bounds
from deploy.theory.gain.tuning import automatic_k, density
from deploy.theory.reachability import mirrored_triples
from protocol.scenario.model import Scenario
from world.judge.clearance import Disks
from world.judge.goals import Goals
from world.judge.measures import tight

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
        tight=tight(Disks(scenario), Goals(scenario)),
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
