"""The proof obligations of every rule: it is possible, and keeps every conjunct of the invariant."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from typing import Any

import z3

from tests.proof.ledger_rules import ledger_cases
from tests.proof.model import IDS, INT, axioms, invariant, quantified, smaller, variables_in
from tests.proof.outcomes import PROPOSED, Case, Outcome, S
from tests.proof.robot_rules import message_cases, robot_cases
from tests.proof.symbolic import ConcreteRun, evaluated, expression, paths

TIMEOUT = 20_000  # ms, of one query
LARGEST = 9  # version or number in a witness
INVARIANT = invariant(S)
GEOMETRY = [
    *axioms(),
    *[each for x in "AB" for each in smaller(x, S[f"{x}.own"], S[f"{x}.body"])],
]

CASES = {case.rule: case for case in (*ledger_cases(), *robot_cases(), *message_cases())}  # by rule
RULES = {  # methods of the kernel that the cases execute
    "Ledger": "rejoin fence settle grant acknowledge introduce ask answer part announce appear remove",
    "RobotLife": "receive freeze turn adopt command locate",
    "Owner": "propose on_answer",
    "Follower": "on_proposal",
}


class Obligation:
    """What is to be proved of one path through a rule."""

    def __init__(self, case: Case, outcome: Outcome, conditions: Sequence[z3.BoolRef]) -> None:
        self.case, self.outcome = case, outcome
        self._assumptions = [*case.given, *conditions, *map(expression, outcome.assumptions)]

    def hypotheses(self) -> list[z3.BoolRef]:
        """The axioms, the invariant before the rule, the path condition, and what the rule assumes."""
        return [*GEOMETRY, *([] if self.case.starts else INVARIANT.values()), *self._assumptions]

    def solver(self) -> z3.Solver:
        """A solver with all hypotheses."""
        made = z3.Solver()
        made.set("timeout", TIMEOUT)
        made.add(*map(quantified, self.hypotheses()))
        return made

    def claims(self) -> dict[str, z3.BoolRef]:
        """Every conjunct of the invariant after the rule, and the other claims of its outcome."""
        after = {field: expression(value) for field, value in self.outcome.after.items()}
        changed = [(S[field], value) for field, value in after.items() if not value.eq(S[field])]
        conjuncts = z3.substitute(z3.And(*INVARIANT.values()), *changed).children()
        others = {name: expression(claim) for name, claim in self.outcome.claims.items()}
        return dict(zip(INVARIANT, conjuncts, strict=True)) | others


def obligations_of(case: Case, without: str = "") -> Iterator[Obligation]:
    """One for every path through a rule, with all preconditions but one, or all."""
    for path in paths(case.run, [*case.given, IDS, *([] if case.starts else INVARIANT.values())], without):
        yield Obligation(case, path.result, path.conditions)


def unproved(case: Case, without: str = "") -> Iterator[tuple[str, Obligation]]:
    """Claims that the solver does not prove, by name."""
    for obligation in obligations_of(case, without):
        solver, claims = obligation.solver(), obligation.claims()
        if not _follows(solver, z3.And(*claims.values())):
            yield from ((name, obligation) for name, each in claims.items() if not _follows(solver, each))


def _follows(solver: z3.Solver, claim: z3.BoolRef) -> bool:
    solver.push()
    solver.add(z3.Not(claim))
    result = solver.check()
    solver.pop()
    return bool(result == z3.unsat)


def is_proved_by_cvc5(obligation: Obligation) -> bool:
    """Whether cvc5 proves all claims, from the text that z3 writes."""
    import cvc5

    writer = obligation.solver()
    writer.add(z3.Not(z3.And(*obligation.claims().values())))
    solver = cvc5.Solver()
    for option in (("tlimit-per", str(TIMEOUT)), ("var-elim-quant", "false"), ("enum-inst", "true")):
        solver.setOption(*option)
    parser = cvc5.InputParser(solver)
    text = "(set-logic ALL)\n" + writer.to_smt2()
    parser.setStringInput(cvc5.InputLanguage.SMT_LIB_2_6, text, "obligation")
    output = ""
    while not (command := parser.nextCommand()).isNull():
        output += command.invoke(solver, parser.getSymbolManager())
    return bool(output.strip() == "unsat")


class Witness:
    """A rule executed in a state of small numbers that satisfies the invariant.

    Attributes:
        rule: its name.
        conjunct: the claim to refute; "" for none.
        refused: preconditions that do not hold.
        invalid: hypotheses that do not hold.
        broken: claims that do not hold afterwards.
    """

    def __init__(self, obligation: Obligation, model: z3.ModelRef, conjunct: str) -> None:
        case = obligation.case
        self.rule, self.conjunct = case.rule, conjunct
        self._model, self._run = model, ConcreteRun(model)
        outcome = evaluated(self._run, case.run)
        self.refused = self._run.refused
        self.invalid = [each for each in obligation.hypotheses() if not self._holds(each)]
        claims = Obligation(case, outcome, ()).claims()
        self.broken = [name for name, claim in claims.items() if not self._holds(claim)]

    def _holds(self, claim: z3.BoolRef) -> bool:
        """Whether a claim holds for all values of its variables."""
        terms = variables_in(claim)
        instances = (
            z3.substitute(claim, *zip(terms, values, strict=True))
            for values in product(*map(self._values, terms))
        )
        return all(map(self._run.answer, instances))

    def _values(self, term: z3.ExprRef) -> list[Any]:
        if term.sort() == INT:
            return [term, *map(z3.IntVal, range(LARGEST + 1))]
        return [term, *(self._model.get_universe(term.sort()) or ())]


def witness(case: Case) -> Witness | None:
    """A state in which a rule is possible."""
    return next(filter(None, map(witness_of, obligations_of(case))), None)


def counterexample(case: Case, without: str = "") -> Witness | None:
    """A state in which a rule breaks a claim, with all preconditions but one, or all."""
    return next(filter(None, (witness_of(each, name) for name, each in unproved(case, without))), None)


def witness_of(obligation: Obligation, conjunct: str = "") -> Witness | None:
    """A state in which a path is possible, and breaks a claim if one is given."""
    solver = obligation.solver()
    solver.add(obligation.outcome.after["v"] <= LARGEST, PROPOSED <= LARGEST)
    solver.add(*[S[f"{b}.A.number"] < LARGEST for b in "LS"])
    if conjunct:
        solver.add(z3.Not(obligation.claims()[conjunct]))
    return Witness(obligation, solver.model(), conjunct) if solver.check() == z3.sat else None
