"""What is seen in practice at the k in use: the exact flow from several starts, and the equilibria found."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from deploy.theory.critical import CriticalPoint, classify
from deploy.theory.equilibria import equilibria, find_equilibrium, swapped_pairs
from deploy.theory.exact_flow import FlowResult, integrate
from deploy.theory.function import Array, Problem, in_free_space
from deploy.theory.sampling import random_configuration
from protocol.draws import Purpose, generator

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
