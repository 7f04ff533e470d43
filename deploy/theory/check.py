"""The report of `disknav check` on robots alone in a disk: theory, and the exact flow at this k. And
the scope of any report, for other laws and external bases.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from deploy.theory.bounds import (
    Bounds,
    ConditionStatus,
    Margins,
    best_bounds,
    first_status,
    margins,
    second_status,
)
from deploy.theory.certify.certificate import GoalSet
from deploy.theory.exact_flow import (
    CriticalPoint,
    FlowResult,
    classify,
    equilibria,
    find_equilibrium,
    integrate,
    random_configuration,
    swapped_pairs,
)
from deploy.theory.facts import Facts
from deploy.theory.function import FleetProblem
from protocol.arrays import Reals
from protocol.draws import Purpose, generator
from protocol.scenario.model import Scenario

LARGEST = 32  # robots
SEARCHED = 12  # largest number of robots for a search of equilibria
RANDOM_STARTS = 10


@dataclass(frozen=True)
class Practice:
    """Behaviour of the exact flow from the scenario's start, the first three, and from random starts."""

    arrived: bool
    nrl: float
    rest: str | None  # kind of equilibrium at which it comes to rest; None if it arrives, or rests nowhere
    random_starts: int
    random_arrived: int
    searched: bool  # otherwise `equilibria` is empty
    equilibria: dict[str, int]  # number of each kind, such as "saddle of index 2", without the goal
    other_minima: int  # besides the goal


def practice(problem: FleetProblem, start: Reals, seed: int) -> Practice | None:
    """Follow the flow and search for equilibria; None beyond 32 robots."""
    if problem.p > LARGEST:
        return None
    starts = _random_starts(problem, seed)
    own, others = integrate(problem, start), [integrate(problem, b) for b in starts]
    searched = problem.p <= SEARCHED
    kinds = _kinds(problem, [own, *others], starts) if searched else Counter()
    arrived = sum(flow.arrived for flow in others)
    rest = None if own.arrived else _rest(problem, own)
    return Practice(own.arrived, own.nrl, rest, len(starts), arrived, searched, dict(kinds), kinds["minimum"])


def _rest(problem: FleetProblem, flow: FlowResult) -> str | None:
    b = find_equilibrium(problem, flow.path[-1])
    return None if b is None else _name(classify(problem, b))


def _random_starts(problem: FleetProblem, seed: int) -> list[Reals]:
    draw = generator(seed, Purpose.STUDY)
    count = RANDOM_STARTS if problem.p <= SEARCHED else 2
    drawn = (random_configuration(draw, problem.radii, problem.workspace) for _ in range(count))
    return [b for b in drawn if b is not None]


def _kinds(problem: FleetProblem, flows: list[FlowResult], starts: list[Reals]) -> Counter[str]:
    ends = (flow.path[-1] for flow in flows if not flow.arrived)
    found = equilibria(problem, [*ends, *swapped_pairs(problem), *starts])[1:]
    return Counter(_name(point) for point in found)


def _name(point: CriticalPoint) -> str:
    return f"saddle of index {point.index}" if point.kind == "saddle" else point.kind


@dataclass(frozen=True)
class Shortfall:
    """A cluster for which an assumption is not shown."""

    robots: tuple[int, ...] | None  # ids; None for all clusters of its size
    size: int
    margin: float  # left-hand side minus right-hand side, m, not positive
    status: ConditionStatus


@dataclass(frozen=True)
class Assumption:
    """One assumption over all clusters, in the limit of small eps; worst: the smallest margin, m."""

    status: ConditionStatus
    worst: float
    clusters: int
    failing: int
    shortfalls: tuple[Shortfall, ...]  # at most LISTED; smallest clusters first, then smallest margins


@dataclass(frozen=True)
class Certified:
    """K of a stored certificate, None if it proves nothing yet; or the reason why it was refused."""

    file: str
    k: float | None
    refused: str | None = None


@dataclass(frozen=True)
class CheckReport:
    """Results of `disknav check` for robots alone in a disk. Lengths in m, eps in m^2."""

    facts: Facts
    unreachable: tuple[tuple[int, int, int], ...]
    every_cluster: bool
    exact: bool  # every cluster, and Lambda', Lambda'' are attained; otherwise they are upper bounds
    assumption_1: Assumption
    assumption_2: Assumption
    bounds: Bounds | None  # at the best eps; None if the assumptions are not shown
    practice: Practice | None
    certificate: Certified | None
    guaranteed: bool  # the theory covers this k

    def render(self) -> RenderableType:
        """Tables and sentences for the terminal."""
        lines = [
            *_assumption_text("Assumption 1 (goals far enough apart)", self.assumption_1),
            *_assumption_text("Assumption 2 (goals off the boundary)", self.assumption_2),
        ]
        bounds: list[RenderableType] = [] if self.bounds is None else [_bounds(self.bounds), Text()]
        notes = (*_verdict(self), CAVEAT, *_certificate(self), "", *_practice(self))
        method = Text(_method(self), style="dim")
        return Group(
            self.facts.table(), Text(), *map(Text, lines), method, Text(), *bounds, *map(Text, notes)
        )


def _orientation(b: Reals, triple: tuple[int, int, int]) -> float:
    """Sign of the turn from robot i over j to k: +1 counter-clockwise, -1 clockwise."""
    (ax, ay), (bx, by) = b[triple[1]] - b[triple[0]], b[triple[2]] - b[triple[0]]
    return float(np.sign(ax * by - ay * bx))


def mirrored_triples(problem: FleetProblem, start: Reals) -> list[tuple[int, int, int]]:
    """Triples of robots (indices, from 0) whose goals are unreachable from `start` for any controller.

    To change their orientation three centres must be collinear at some time; the disks then take 2 (rho_i +
    rho_j + rho_k) of one chord, which is at most 2 rho_0. So with rho_i + rho_j + rho_k > rho_0 the
    orientation of the triple never changes. The condition is sufficient for unreachability, not necessary.
    """
    return sorted(
        triple
        for triple in _wide_triples(problem)
        if _orientation(start, triple) != _orientation(problem.goals, triple)
    )


def _wide_triples(problem: FleetProblem) -> Iterator[tuple[int, int, int]]:
    """Triples with rho_i + rho_j + rho_k > rho_0, searched from the largest disks."""
    order = [int(i) for i in np.argsort(-problem.radii)]
    radius = problem.radii
    for first in range(problem.p - 2):
        for second in range(first + 1, problem.p - 1):
            for third in range(second + 1, problem.p):
                i, j, k = sorted((order[first], order[second], order[third]))
                if radius[[i, j, k]].sum() <= problem.workspace:
                    if third == second + 1 == first + 2:
                        return
                    break
                yield i, j, k


LISTED = 5  # shortfalls in a report


def report(scenario: Scenario, certificate: Certified | None = None) -> CheckReport:
    """Evaluate the theory for a valid scenario with a number for k; follow the exact flow from some starts.

    Takes from milliseconds to a few seconds; beyond 32 robots `practice` is left out.
    """
    ids = scenario.ids
    problem = replace(GoalSet.of(scenario).problem, k=scenario.k)
    start = np.array([scenario.spec(robot).start for robot in ids], dtype=np.float64)
    found, limits = margins(problem, 0.0), best_bounds(problem)
    several = np.flatnonzero(found.clusters.sizes >= 2)
    return CheckReport(
        facts=Facts.of(scenario),
        unreachable=tuple((ids[i], ids[j], ids[k]) for i, j, k in mirrored_triples(problem, start)),
        every_cluster=found.clusters.enumerated,
        exact=bool(found.stretch.exact[several].all()),
        assumption_1=_assumption(
            ids, found, found.first, several, lambda row: first_status(problem, found, row, 0.0)
        ),
        assumption_2=_assumption(ids, found, found.second, several, lambda row: second_status(found, row)),
        bounds=limits,
        practice=practice(problem, start, scenario.seed),
        certificate=certificate,
        guaranteed=limits is not None and scenario.k > limits.polar,
    )


def _assumption(
    ids: tuple[int, ...],
    found: Margins,
    values: Reals,
    rows: np.ndarray[Any, np.dtype[np.intp]],
    status: Callable[[int], ConditionStatus],
) -> Assumption:
    failing = [int(row) for row in rows if not values[row] > 0.0]
    failing.sort(key=lambda row: (found.clusters.sizes[row], values[row]))
    states = [status(row) for row in failing]
    listed = [
        Shortfall(_names(ids, found, row), int(found.clusters.sizes[row]), float(values[row]), state)
        for row, state in zip(failing[:LISTED], states[:LISTED], strict=True)
    ]
    overall: ConditionStatus = "violated" if "violated" in states else "not shown" if states else "holds"
    worst = float(values[rows].min()) if len(rows) else float("inf")
    return Assumption(overall, worst, len(rows), len(failing), tuple(listed))


def _names(ids: tuple[int, ...], found: Margins, row: int) -> tuple[int, ...] | None:
    members = found.clusters.names(row)
    return None if members is None else tuple(ids[i] for i in members)


# -- as text

CAVEAT = (
    "The conditions are sufficient and very conservative; the paper's own simulations never check them. "
    "Where they fail the theory says nothing about arrival."
)


def scope(scenario: Scenario) -> list[str]:
    """Validity of the report for other laws, and the bounds that external bases must keep."""
    law, notes = scenario.control.law, []
    if law == "external":
        notes.append("The law is external: bounds on k do not apply, and arrival depends on the planners.")
    elif law != "gradient":
        notes.append(f"Bounds on k are for the law gradient; arrival with {law} is not proven for any k.")
    if scenario.is_external and scenario.control.filter != "none":
        notes += [
            "",
            "External bases: no collision as long as these stated bounds hold, which are not measured here.",
            *_stated(scenario),
        ]
    return notes


def _stated(scenario: Scenario) -> Iterator[str]:
    robots: dict[str, list[str]] = {}
    for robot in scenario.ids:
        body, base = scenario.body_of(robot), scenario.base_of(robot)
        if base is not None:
            stands = scenario.world.lease + body.hold + body.speed / body.acceleration
            age = base.age + base.latency
            text = (
                f"continues for {base.patience:g} s without ticks, for {base.timeout:g} s without its "
                f"process; messages take at most {base.latency:g} s; odometry is at most {age:g} s old; "
                f"stands at most {stands:.2g} s after its newest confirmed command"
            )
            robots.setdefault(text, []).append(str(robot))
    for text, ids in robots.items():
        yield f"{'each of robots' if len(ids) > 1 else 'robot'} {', '.join(ids)}: {text}"


def _assumption_text(name: str, found: Assumption) -> list[str]:
    if found.status == "holds":
        least = f", by {found.worst:.4f} m or more" if found.clusters else ""
        return [f"{name}: holds for all clusters{least}"]
    head = f"{name}: {found.status}, for {found.failing} of {found.clusters} clusters"
    more = found.failing - len(found.shortfalls)
    tail = [f"  ... and {more} more"] if more > 0 else []
    return [head, *(_shortfall(entry) for entry in found.shortfalls), *tail]


def _shortfall(entry: Shortfall) -> str:
    if entry.robots is None:
        robots = f"some {entry.size} robots"
    else:
        robots = "robots " + ", ".join(map(str, entry.robots))
    return f"  {robots}: {entry.status}, short by {-entry.margin:.4f} m"


def _method(found: CheckReport) -> str:
    if not found.every_cluster:
        return "More than 12 robots: bounded per cluster size; Lambda', Lambda'' are proven upper bounds."
    how = "exact" if found.exact else "proven upper bounds, not always attained"
    return f"All subsets of two or more robots; Lambda' and Lambda'' are {how}."


def _bounds(bounds: Bounds) -> Table:
    table = Table(title=f"Bounds on k at the best eps = {bounds.eps:.3g} m²", title_justify="left")
    for column in ("bound", "value", "consequence of a larger k"):
        table.add_column(column)
    table.add_row("K1", f"{bounds.k1.low:.4g} to {bounds.k1.high:.4g}", "no critical point off all obstacles")
    table.add_row("K21", f"at most {bounds.k21:.4g}", "clusters repel enough to turn (Lemma E.15)")
    table.add_row("K2", f"at most {bounds.k2:.4g}", "no minimum where robots are close (K22 corrected)")
    table.add_row("K3", f"at most {bounds.k3:.4g}", "no critical point near the outer boundary")
    table.add_row("K", f"{bounds.polar:.4g}", "the goal is the only minimum (Proposition 3.1)")
    table.add_row("N1", str(bounds.n1), "first part of Proposition D.2")
    table.add_row("N2", "infinite", "Proposition D.2 cannot hold where saddles exist")
    return table


def _verdict(found: CheckReport) -> list[str]:
    if found.unreachable:
        triples = "; ".join(", ".join(map(str, triple)) for triple in found.unreachable)
        return [
            f"UNREACHABLE by any controller: robots {triples} can never be in a line, so they cannot "
            "change their orientation, and start and goal differ in it."
        ]
    if found.bounds is None and found.assumption_1.status == found.assumption_2.status == "holds":
        return [
            "Arrival is not proven for any k: Proposition C.3 also needs goals and clusters well off the rim."
        ]
    if found.bounds is None:
        return ["Arrival is not proven for any k, since the assumptions are not shown."]
    reach = "is above it: guaranteed" if found.guaranteed else "is below it: not covered"
    return [
        f"Proven: for k > {found.bounds.polar:.4g} the goal is the only minimum and almost every start leads "
        f"there. k = {found.facts.k:.4g} {reach}.",
        "Not proven: that phi is Morse. Almost every start needs only that every other equilibrium has a "
        "direction of descent, which K2 gives.",
    ]


def _certificate(found: CheckReport) -> list[str]:
    stored = found.certificate
    if stored is None:
        return ["No certificate: `disknav certify` proves a k for these goals by computation."]
    if stored.refused is not None:
        return [f"Certificate refused: {stored.refused}"]
    if stored.k is None:
        return [f"{stored.file} proves nothing yet: repeat `disknav certify` to continue it."]
    use = "is covered" if found.facts.k >= stored.k else "is not covered"
    return [
        f"Certified by computation ({stored.file}): for every k >= {stored.k:.4g} the goal is the only "
        f"minimum and every other critical point has a direction of descent. k = {found.facts.k:.4g} {use}."
    ]


def _practice(found: CheckReport) -> list[str]:
    seen = found.practice
    if seen is None:
        return ["In practice: not tried with more than 32 robots."]
    own = f"arrives, nrl {seen.nrl:.2f}" if seen.arrived else _rest_text(seen.rest)
    lines = [
        f"In practice at k = {found.facts.k:.4g}, exact flow: the scenario's start {own}; "
        f"{seen.random_arrived} of {seen.random_starts} random starts arrive."
    ]
    if seen.searched:
        kinds = ", ".join(_counted(count, kind) for kind, count in sorted(seen.equilibria.items()))
        lines.append(f"Equilibria found besides the goal: {kinds or 'none'}; more may exist.")
    if seen.other_minima:
        lines.append(f"{seen.other_minima} of them are minima, where the fleet can come to rest. Raise k.")
    return lines


def _counted(count: int, kind: str) -> str:
    noun, _, rest = kind.partition(" ")
    plural = {"minimum": "minima"}.get(noun, f"{noun}s")
    return " ".join(filter(None, (str(count), noun if count == 1 else plural, rest)))


def _rest_text(kind: str | None) -> str:
    if kind is None:
        return "does NOT arrive"
    if kind.startswith("saddle"):
        return f"comes to rest at a {kind}, which any disturbance leaves (such starts have measure zero)"
    return f"does NOT arrive: it comes to rest at another {kind}"
