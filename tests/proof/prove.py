"""Whether every rule keeps every conjunct of the invariant, and is possible."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain, product
from typing import Any

import z3

from tests.proof.ledger_rules import ledger_cases
from tests.proof.model import IDS, LINE_OF, Terms, axioms, ends, invariant, safe, smaller
from tests.proof.outcomes import HALF_PLANE, NEXT, PROPOSED, Case, Outcome, S
from tests.proof.robot_rules import robot_cases, tells
from tests.proof.symbolic import Execution, expression, judged, ways

TIMEOUT = 20_000  # ms, for one question
SMALL = (5, 9)  # no version or number of an example is larger; tried in turn
RA, RB, K = z3.Int("any A"), z3.Int("any B"), z3.Int("any K")  # two regions and the number of a line
TEMPLATE = invariant(S, RA, RB, K) | {"safe": safe(S)}
ALL = z3.And(*TEMPLATE.values())


CASES = {case.rule: case for case in (*ledger_cases(), *robot_cases(), *tells())}  # every rule
GENERAL = {
    name: [term for term in (RA, RB, K) if not z3.substitute(conjunct, (term, z3.IntVal(0))).eq(conjunct)]
    for name, conjunct in TEMPLATE.items()
}  # the general terms that a conjunct mentions


def instances(name: str, claim: z3.BoolRef, *ranges: Sequence[z3.ArithRef]) -> Iterator[z3.BoolRef]:
    """What a conjunct says, now or after a step, of all these regions of A, of B and numbers."""
    general = GENERAL.get(name, [])
    for values in product(*[ranges[(RA, RB, K).index(term)] for term in general]):
        yield z3.substitute(claim, *zip(general, values, strict=True))


def terms_of(outcome: Outcome, largest: int = -1) -> Terms:
    """The terms for which quantified facts are written out: all that there are, if no version is above the
    largest.
    """
    t, came_up, whole = Terms(), outcome.terms, _up_to(largest)
    for x, any_region in (("A", RA), ("B", RB)):
        regions = [any_region, *[S[f"{x}.{f}"] for f in ("acked", "granted", "obeyed", "offered")]]
        t.bodies[x] = _different([S[f"{x}.body"], S[f"{x}.own"], *came_up.bodies[x]])
        t.regions[x] = _different([*regions, *came_up.regions[x], *whole])
    numbers = [K, z3.IntVal(0), PROPOSED, *[ends(S, b)["adopted"] for b in "LS"], *came_up.numbers]
    t.numbers = _different([*numbers, *whole])
    lines = [S[f"{b}.{x}.half"] for b in "LS" for x in "AB"] + [HALF_PLANE, LINE_OF(NEXT, 0)]
    t.lines = _different(lines + [LINE_OF(S[f"{b}.number"], k) for b in "LS" for k in t.numbers])
    t.lines += came_up.lines
    return t


def _different(terms: Sequence[Any]) -> list[Any]:
    return list({each.get_id(): each for each in terms}.values())


def _up_to(largest: int) -> list[z3.ArithRef]:
    return [z3.IntVal(number) for number in range(largest + 1)]


_known: dict[str, tuple[Terms, list[z3.BoolRef]]] = {}


def known(t: Terms, starts: bool) -> list[z3.BoolRef]:
    """The invariant before a step, but of the first one, and geometry, of all these terms; most rules bring
    up the same ones.
    """
    terms = (t.bodies["A"], t.bodies["B"], t.regions["A"], t.regions["B"], t.numbers, t.lines)
    key = f"{[[each.get_id() for each in every] for every in terms]} {starts}"
    if key not in _known:
        facts: list[z3.BoolRef] = []
        for name, conjunct in () if starts else TEMPLATE.items():
            facts += instances(name, conjunct, t.regions["A"], t.regions["B"], t.numbers)
        facts += axioms(t)
        for x in "AB":
            facts += smaller(x, S[f"{x}.own"], S[f"{x}.body"], t)
        _known[key] = t, facts
    return _known[key][1]


class Step:
    """One way through a rule, with all that is known before it."""

    def __init__(
        self, case: Case, outcome: Outcome, conditions: Sequence[z3.BoolRef], t: Terms | None = None
    ) -> None:
        self.case, self.outcome, self.conditions = case, outcome, conditions
        self.terms = t or terms_of(outcome)
        self.given = [*case.given, *conditions]
        self.given += chain.from_iterable(facts(self.terms) for facts in outcome.facts)

    def assumed(self) -> list[z3.BoolRef]:
        """All that is known."""
        return [*known(self.terms, self.case.starts), *self.given]

    def claims(self) -> dict[str, z3.BoolRef]:
        """Every conjunct after it, and what is claimed besides."""
        after = {field: expression(value) for field, value in self.outcome.after.items()}
        changed = [(S[field], value) for field, value in after.items() if not value.eq(S[field])]
        return {
            **{name: z3.substitute(conjunct, *changed) for name, conjunct in TEMPLATE.items()},
            **{name: expression(claim) for name, claim in self.outcome.claims.items()},
        }


_solvers: dict[int, z3.Solver] = {}


def _solver_with(facts: list[z3.BoolRef]) -> z3.Solver:
    """One that knows these facts."""
    if id(facts) not in _solvers:
        _solvers[id(facts)] = z3.Solver()
        _solvers[id(facts)].set("timeout", TIMEOUT)
        _solvers[id(facts)].add(*facts)
    return _solvers[id(facts)]


def steps_of(case: Case, without: str = "") -> Iterator[Step]:
    """Every way through a rule, with a precondition left out or none."""
    for way in ways(case.run, [*case.given, IDS, *([] if case.starts else [ALL])], without):
        yield Step(case, way.result, way.conditions)


def not_kept(case: Case, without: str = "") -> Iterator[tuple[str, Step]]:
    """What a rule is not proved to keep, by conjunct, and in which way through it."""
    for step in steps_of(case, without):
        solver = _solver_with(known(step.terms, case.starts))
        solver.push()
        try:
            solver.add(*step.given)
            claims = step.claims()
            if not _follows(solver, z3.And(*claims.values())):
                yield from ((name, step) for name, each in claims.items() if not _follows(solver, each))
        finally:
            solver.pop()


def _follows(solver: z3.Solver, claim: z3.BoolRef) -> bool:
    solver.push()
    solver.add(z3.Not(claim))
    result = solver.check()
    solver.pop()
    return bool(result == z3.unsat)


def is_kept_by_cvc5(step: Step) -> bool:
    """Whether all is kept in one way through a rule by cvc5, which knows nothing of z3 but the text."""
    import cvc5

    writer, knows = z3.Solver(), known(step.terms, step.case.starts)
    writer.add(*knows, *step.given, z3.Not(z3.And(*step.claims().values())))
    solver = cvc5.Solver()
    solver.setOption("tlimit-per", str(TIMEOUT))
    parser = cvc5.InputParser(solver)
    text = f"(set-logic ALL)\n{writer.to_smt2()}"
    parser.setStringInput(cvc5.InputLanguage.SMT_LIB_2_6, text, "obligation")
    said = ""
    while not (command := parser.nextCommand()).isNull():
        said += command.invoke(solver, parser.getSymbolManager())
    return bool(said.strip() == "unsat")


class Example:
    """A rule executed in a state of small numbers, in which the whole invariant holds.

    Attributes:
        rule: its name.
        conjunct: that it was to break, if any.
        refused: preconditions that do not hold.
        invalid: whatever was taken for granted and does not hold.
        broken: conjuncts that do not hold afterwards.
    """

    def __init__(self, step: Step, model: z3.ModelRef, largest: int, conjunct: str) -> None:
        self.rule, self.conjunct = step.case.rule, conjunct
        self._model, self._whole = model, _up_to(largest)
        execution = Execution(model)
        outcome = judged(execution, step.case.run)
        self.refused = execution.refused
        self.invalid = [each for each in step.assumed() if not self._holds(each)]
        claims = Step(step.case, outcome, (), step.terms).claims()
        self.broken = [name for name, claim in claims.items() if not self._keeps(name, claim)]

    def _holds(self, claim: z3.BoolRef) -> bool:
        return bool(z3.is_true(self._model.eval(claim, model_completion=True)))

    def _keeps(self, name: str, claim: z3.BoolRef) -> bool:
        """Whether a claim holds of all regions and numbers."""
        return all(map(self._holds, instances(name, claim, self._whole, self._whole, self._whole)))


def example(case: Case) -> Example | None:
    """A state in which a rule is possible."""
    found = (example_of(step, largest) for largest in SMALL for step in steps_of(case))
    return next(filter(None, found), None)


def counterexample(case: Case, without: str = "") -> Example | None:
    """What a rule breaks, with a precondition left out or none."""
    broken = not_kept(case, without)
    found = (example_of(step, largest, conjunct) for conjunct, step in broken for largest in SMALL)
    return next(filter(None, found), None)


def example_of(step: Step, largest: int, conjunct: str = "") -> Example | None:
    """A state in which one way through a rule is possible, or breaks a conjunct."""
    small = Step(step.case, step.outcome, step.conditions, terms_of(step.outcome, largest))
    solver = z3.Solver()
    solver.set("timeout", TIMEOUT)
    solver.add(*small.assumed(), small.outcome.after["v"] <= largest)
    solver.add(*[S[f"{b}.A.number"] < largest for b in "LS"], largest >= PROPOSED)
    if conjunct:
        solver.add(z3.Not(small.claims()[conjunct]))
    return Example(small, solver.model(), largest, conjunct) if solver.check() == z3.sat else None
