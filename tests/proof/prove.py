"""Whether every rule keeps every conjunct of the invariant, and is possible."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from typing import Any

import z3

from tests.proof.ledger_rules import ledger_cases
from tests.proof.model import IDS, INT, axioms, general_in, invariant, of_all, smaller
from tests.proof.outcomes import PROPOSED, Case, Outcome, S
from tests.proof.robot_rules import robot_cases, tells
from tests.proof.symbolic import Execution, expression, judged, ways

TIMEOUT = 20_000  # ms, for one question
LARGEST = 9  # no version or number of an example is larger
TEMPLATE = invariant(S)
GEOMETRY = [*axioms(), *[fact for x in "AB" for fact in smaller(x, S[f"{x}.own"], S[f"{x}.body"])]]

CASES = {case.rule: case for case in (*ledger_cases(), *robot_cases(), *tells())}  # every rule
RULES = {  # the kernel's methods that these execute
    "Ledger": "rejoin fence settle grant acknowledge introduce ask answer part announce appear remove",
    "RobotLife": "hear freeze turn adopt command locate",
    "Owner": "propose on_answer",
    "Follower": "on_proposal",
}


class Step:
    """One way through a rule, with all that is known before it."""

    def __init__(self, case: Case, outcome: Outcome, conditions: Sequence[z3.BoolRef]) -> None:
        self.case, self.outcome = case, outcome
        self.facts = [*case.given, *conditions, *map(expression, outcome.facts)]

    def known(self) -> list[z3.BoolRef]:
        """All that is known."""
        return [*GEOMETRY, *([] if self.case.starts else TEMPLATE.values()), *self.facts]

    def solver(self) -> z3.Solver:
        """One that knows all this."""
        made = z3.Solver()
        made.set("timeout", TIMEOUT)
        made.add(*map(of_all, self.known()))
        return made

    def claims(self) -> dict[str, z3.BoolRef]:
        """Every conjunct after it, and what is claimed besides."""
        after = {field: expression(value) for field, value in self.outcome.after.items()}
        changed = [(S[field], value) for field, value in after.items() if not value.eq(S[field])]
        conjuncts = z3.substitute(z3.And(*TEMPLATE.values()), *changed).children()
        besides = {name: expression(claim) for name, claim in self.outcome.claims.items()}
        return dict(zip(TEMPLATE, conjuncts, strict=True)) | besides


def steps_of(case: Case, without: str = "") -> Iterator[Step]:
    """Every way through a rule, with a precondition left out or none."""
    for way in ways(case.run, [*case.given, IDS, *([] if case.starts else TEMPLATE.values())], without):
        yield Step(case, way.result, way.conditions)


def not_kept(case: Case, without: str = "") -> Iterator[tuple[str, Step]]:
    """What a rule is not proved to keep, by conjunct, and in which way through it."""
    for step in steps_of(case, without):
        solver, claims = step.solver(), step.claims()
        if not _follows(solver, z3.And(*claims.values())):
            yield from ((name, step) for name, each in claims.items() if not _follows(solver, each))


def _follows(solver: z3.Solver, claim: z3.BoolRef) -> bool:
    solver.push()
    solver.add(z3.Not(claim))
    result = solver.check()
    solver.pop()
    return bool(result == z3.unsat)


def is_kept_by_cvc5(step: Step) -> bool:
    """Whether all is kept in one way through a rule by cvc5, which knows nothing of z3 but the text."""
    import cvc5

    writer = step.solver()
    writer.add(z3.Not(z3.And(*step.claims().values())))
    solver = cvc5.Solver()
    for option in (("tlimit-per", str(TIMEOUT)), ("var-elim-quant", "false"), ("enum-inst", "true")):
        solver.setOption(*option)
    parser = cvc5.InputParser(solver)
    text = "(set-logic ALL)\n" + writer.to_smt2()
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

    def __init__(self, step: Step, model: z3.ModelRef, conjunct: str) -> None:
        self.rule, self.conjunct = step.case.rule, conjunct
        self._model, self._execution = model, Execution(model)
        outcome = judged(self._execution, step.case.run)
        self.refused = self._execution.refused
        self.invalid = [each for each in step.known() if not self._holds(each)]
        claims = Step(step.case, outcome, ()).claims()
        self.broken = [name for name, claim in claims.items() if not self._holds(claim)]

    def _holds(self, claim: z3.BoolRef) -> bool:
        """Whether a claim holds of all that it mentions."""
        terms = general_in(claim)
        all_of_them = (
            z3.substitute(claim, *zip(terms, values, strict=True))
            for values in product(*map(self._every, terms))
        )
        return all(map(self._execution.answer, all_of_them))

    def _every(self, term: z3.ExprRef) -> list[Any]:
        """What a general term may mean."""
        if term.sort() == INT:
            return [term, *map(z3.IntVal, range(LARGEST + 1))]
        return [term, *(self._model.get_universe(term.sort()) or ())]


def example(case: Case) -> Example | None:
    """A state in which a rule is possible."""
    return next(filter(None, map(example_of, steps_of(case))), None)


def counterexample(case: Case, without: str = "") -> Example | None:
    """What a rule breaks, with a precondition left out or none."""
    return next(filter(None, (example_of(step, name) for name, step in not_kept(case, without))), None)


def example_of(step: Step, conjunct: str = "") -> Example | None:
    """A state in which one way through a rule is possible, or breaks a conjunct."""
    solver = step.solver()
    solver.add(step.outcome.after["v"] <= LARGEST, PROPOSED <= LARGEST)
    solver.add(*[S[f"{b}.A.number"] < LARGEST for b in "LS"])
    if conjunct:
        solver.add(z3.Not(step.claims()[conjunct]))
    return Example(step, solver.model(), conjunct) if solver.check() == z3.sat else None
