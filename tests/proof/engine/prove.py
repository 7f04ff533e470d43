"""Is an invariant kept by every rule? One small question for each rule and each conjunct that it touches."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import z3

from tests.proof.engine.logic import Term, every
from tests.proof.engine.state import Symbolic
from tests.proof.engine.system import System, Text, needs_of

TIMEOUT = 10_000  # ms, for one question in one way
PATTERNS = 12  # of one statement, at most
WAYS: tuple[dict[str, Any], ...] = (  # tried in turn: what z3 finds depends on how it splits cases
    {},
    {"smt.auto_config": False},
    {"smt.case_split": 3},
    {"smt.random_seed": 7, "smt.auto_config": False, "smt.case_split": 3},
)

Ask = Callable[[list[z3.BoolRef]], bool]  # whether these statements contradict each other, for certain


@dataclass(frozen=True)
class Obligation:
    """That a rule keeps a conjunct, and how long it took to prove, in s of this process."""

    rule: str
    conjunct: str
    proved: bool
    seconds: float


class Step:
    """A rule applied to any state.

    Args:
        but: what it needs, and is left out.

    Attributes:
        guard: all that it needs.
        before, after: the states.
    """

    def __init__(self, system: System, rule: Text, but: Collection[str] = ()) -> None:
        self.before = Symbolic(system.schema)
        self.after = self.before.after()
        self.args, self._first = constants(rule, "rule"), rule.starts
        needs = needs_of(rule, self.before, self.after, self.args, but)
        self.guard: Term = every(z3.BoolVal(True), *[condition for _, condition in needs])

    def touched(self, conjuncts: Iterable[Text]) -> Iterator[tuple[Text, Term]]:
        """Conjuncts that say something else of the state after it, and what, of any values."""
        for conjunct in conjuncts:
            values = constants(conjunct, "some")
            after = conjunct.run(self.after, *values)
            if self._first or not z3.eq(z3.simplify(conjunct.run(self.before, *values)), z3.simplify(after)):
                yield conjunct, after


def constants(text: Text, prefix: str) -> tuple[z3.ExprRef, ...]:
    """Any values of the parameters of a text."""
    return tuple(z3.Const(f"{prefix}!{name}", sort.z3) for name, sort in text.parameters.items())


def prove(system: System, rule: Text, ask: Ask | None = None, but: Collection[str] = ()) -> list[Obligation]:
    """Whether a rule keeps each conjunct that it touches.

    Args:
        ask: the solver; z3, unless given.
        but: what the rule needs, and is left out.
    """
    step = Step(system, rule, but)
    known = hypotheses(system, rule, step)
    found = []
    for conjunct, after in step.touched(system.conjuncts.values()):
        begun = time.process_time()
        proved = (ask or contradicts)([*known, z3.Not(after)])
        found.append(Obligation(rule.name, conjunct.name, proved, time.process_time() - begun))
    return found


def hypotheses(system: System, rule: Text, step: Step) -> list[z3.BoolRef]:
    """What is known: the axioms, the invariant of the state before, and that the rule is possible."""
    known = [forall(axiom) for axiom in system.axioms.values()]
    known += [
        forall(conjunct, step.before) for conjunct in (() if rule.starts else system.conjuncts.values())
    ]
    return [*known, step.guard]


def contradicts(statements: list[z3.BoolRef]) -> bool:
    """Ask z3. It looks for no models where there are quantifiers: it proves, or soon gives up."""
    for way in WAYS:
        solver = z3.SimpleSolver()
        solver.set("timeout", TIMEOUT)
        solver.set("smt.mbqi", False)
        for name, value in way.items():
            solver.set(name, value)
        solver.add(*statements)
        if solver.check() == z3.unsat:
            return True
    return False


def contradicts_for_cvc5(statements: list[z3.BoolRef]) -> bool:
    """Ask cvc5, which knows nothing of z3 but the text."""
    import cvc5

    writer = z3.Solver()
    writer.add(*statements)
    solver = cvc5.Solver()
    solver.setOption("tlimit-per", str(TIMEOUT))
    parser = cvc5.InputParser(solver)
    parser.setStringInput(
        cvc5.InputLanguage.SMT_LIB_2_6, f"(set-logic ALL)\n{writer.to_smt2()}", "obligation"
    )
    said = ""
    while not (command := parser.nextCommand()).isNull():
        said += command.invoke(solver, parser.getSymbolManager())
    return bool(said.strip() == "unsat")


def forall(text: Text, *states: Symbolic) -> z3.BoolRef:
    """What a conjunct or an axiom says, of all values of its parameters."""
    variables = constants(text, "all")
    body = text.run(*states, *variables)
    return z3.ForAll(list(variables), body, patterns=_patterns(variables, body)) if variables else body


def _patterns(variables: tuple[z3.ExprRef, ...], body: z3.BoolRef) -> list[z3.PatternRef]:
    """Terms by which a solver sees what a statement may be about: each that names all its variables, or if
    there are none, each few that do together."""
    names = {each.get_id() for each in variables}
    found = list(_flat(body, names, set()))
    for many in range(1, len(variables) + 1):
        chosen = [
            some
            for some in combinations(found, many)
            if {arg.get_id() for term in some for arg in term.children()} >= names
        ]
        if chosen:
            return [some[0] if many == 1 else z3.MultiPattern(*some) for some in chosen[:PATTERNS]]
    return []


def _flat(term: z3.ExprRef, names: set[int], seen: set[int]) -> Iterator[z3.ExprRef]:
    """Variables of the state, and relations, of nothing but variables of the statement; each once."""
    if term.get_id() in seen:
        return
    seen.add(term.get_id())
    args = term.children()
    if args and term.decl().kind() == z3.Z3_OP_UNINTERPRETED and all(arg.get_id() in names for arg in args):
        yield term
    for arg in args:
        yield from _flat(arg, names, seen)
