"""States found by the solver, and executed: examples of a rule, and counterexamples.

Quantifiers are written out in a small universe, and only where it turns out to matter: a model is read as a
state of plain values, the texts of the invariant are run on it, and what fails is asked for in the next one.
What is returned has been executed by the same text that was proved.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any

import z3

from tests.proof.engine.logic import BOOL, INT, TABLES, Sort
from tests.proof.engine.prove import Step, constants
from tests.proof.engine.state import Concrete, base
from tests.proof.engine.system import System, Text, needs_of

MOST = 40  # instances of one text that are added at a time


@dataclass(frozen=True)
class Example:
    """A rule that was executed.

    Attributes:
        before, after: the states.
        args: of the rule.
        broken: names of the conjuncts that fail afterwards.
    """

    before: Concrete
    after: Concrete
    args: tuple[Any, ...]
    broken: tuple[str, ...]


class Universe:
    """What there is: integers from 0 to `most`, and so many individuals of each other sort."""

    def __init__(self, system: System, most: int, individuals: int) -> None:
        self.system, self.most = system, most
        kinds = [*system.schema.values(), *system.relations]
        sorts = {sort for kind in kinds for sort in (*kind.over, getattr(kind, "kind", BOOL))}
        self.values: dict[Sort, list[Any]] = {
            sort: list(range(most + 1))
            if sort == INT
            else [False, True]
            if sort == BOOL
            else [f"{sort.name}{i}" for i in range(individuals)]
            for sort in sorts
        }
        self.tables = {name: self._table(base(name, each), each.over) for name, each in system.schema.items()}
        self.tables |= {each.name: self._table(each.z3, each.over) for each in system.relations}

    def _table(self, function: z3.FuncDeclRef, over: tuple[Sort, ...]) -> dict[tuple[Any, ...], z3.ExprRef]:
        """A map at all points."""
        return {
            point: function(*[self.term(sort, each) for sort, each in zip(over, point, strict=True)])
            for point in self.points(over)
        }

    def term(self, sort: Sort, value: Any) -> z3.ExprRef:
        """A value for the solver."""
        if sort == INT:
            return z3.IntVal(value)
        return z3.BoolVal(value) if sort == BOOL else z3.Const(value, sort.z3)

    def distinct(self) -> Iterator[z3.BoolRef]:
        """That all individuals differ."""
        for sort, values in self.values.items():
            if sort not in (INT, BOOL):
                yield z3.Distinct(*[self.term(sort, value) for value in values])

    def among(self, sort: Sort, term: z3.ExprRef) -> z3.BoolRef:
        """That a term is one of the values that there are."""
        if sort == BOOL:
            return z3.BoolVal(True)
        if sort == INT:
            return z3.And(term >= 0, term <= self.most)
        return z3.Or(*[term == self.term(sort, value) for value in self.values[sort]])

    def points(self, sorts: Collection[Sort]) -> Iterator[tuple[Any, ...]]:
        """All values of some parameters."""
        return product(*[self.values[sort] for sort in sorts])


class _Reading:
    """A model, read as a state; None where it names what there is not, which `missing` then forbids."""

    def __init__(self, universe: Universe, model: z3.ModelRef) -> None:
        self.universe, self.missing = universe, list[z3.BoolRef]()
        self._model = model
        self._names = {
            sort: {model.eval(universe.term(sort, value), True).get_id(): value for value in values}
            for sort, values in universe.values.items()
            if sort not in (INT, BOOL)
        }
        system = universe.system
        tables = {name: self._table(name, variable.kind) for name, variable in system.schema.items()}
        self.state = Concrete(system.schema, universe.values, tables)
        self.relations = {each.name: self._table(each.name, BOOL) for each in system.relations}

    def _table(self, name: str, kind: Sort) -> dict[tuple[Any, ...], Any]:
        return {point: self.value(kind, term) for point, term in self.universe.tables[name].items()}

    def value(self, sort: Sort, term: z3.ExprRef) -> Any:
        """What a term is in the model."""
        found = self._model.eval(term, True)
        if sort == BOOL:
            return z3.is_true(found)
        value = found.as_long() if sort == INT else self._names[sort].get(found.get_id())
        if value is None or (sort == INT and not 0 <= value <= self.universe.most):
            self.missing.append(self.universe.among(sort, term))
            return sort.default
        return value


def find(
    system: System,
    rule: Text,
    universe: Universe,
    goal: Text | None = None,
    but: Collection[str] = (),
    tries: int = 400,
) -> Example | None:
    """A state with the whole invariant in which a rule is possible, and its outcome; with a `goal`, one after
    which this conjunct fails. None if the universe has none.

    Args:
        but: what the rule needs and is left out.
        tries: models that are read at most.

    Raises:
        TimeoutError: there was no answer by then.
    """
    step = Step(system, rule, but)
    solver = z3.SimpleSolver()
    solver.add(*universe.distinct(), step.guard)
    for sort, arg in zip(rule.parameters.values(), step.args, strict=True):
        solver.add(universe.among(sort, arg))
    wanted: tuple[z3.ExprRef, ...] = ()
    if goal is not None:
        wanted = constants(goal, "some")
        for sort, arg in zip(goal.parameters.values(), wanted, strict=True):
            solver.add(universe.among(sort, arg))
        solver.add(z3.Not(goal.run(step.after, *wanted)))
    for _ in range(tries):
        if solver.check() != z3.sat:
            return None
        reading = _Reading(universe, solver.model())
        if not _forbid(solver, system, rule, step, reading):
            args = tuple(
                reading.value(sort, arg)
                for sort, arg in zip(rule.parameters.values(), step.args, strict=True)
            )
            values = (
                ()
                if goal is None
                else tuple(
                    reading.value(sort, arg)
                    for sort, arg in zip(goal.parameters.values(), wanted, strict=True)
                )
            )
            return execute(system, rule, reading, args, but, goal, values)
    raise TimeoutError(f"{rule.name}: no answer after {tries} models")


def _forbid(solver: z3.Solver, system: System, rule: Text, step: Step, reading: _Reading) -> bool:
    """Ask for all that the model lacks; whether that was anything."""
    universe = reading.universe
    lacking = list(reading.missing)
    _run_with(reading)
    for axiom in system.axioms.values():
        for point in _failing(axiom, universe):
            lacking.append(axiom.run(*_terms(universe, axiom, point)))
    for conjunct in () if rule.starts else system.conjuncts.values():
        for point in _failing(conjunct, universe, reading.state):
            lacking.append(conjunct.run(step.before, *_terms(universe, conjunct, point)))
    solver.add(*lacking)
    return bool(lacking)


def _terms(universe: Universe, text: Text, point: tuple[Any, ...]) -> list[z3.ExprRef]:
    return [universe.term(sort, value) for sort, value in zip(text.parameters.values(), point, strict=True)]


def _failing(text: Text, universe: Universe, *states: Concrete) -> list[tuple[Any, ...]]:
    """Values for which a text does not hold; not all, if there are many."""
    found: list[tuple[Any, ...]] = []
    for point in universe.points(text.parameters.values()):
        if not text.run(*states, *point):
            found.append(point)
            if len(found) >= MOST:
                break
    return found


def _run_with(reading: _Reading) -> None:
    """Let relations be those of the model."""
    for name, table in reading.relations.items():
        TABLES[name] = lambda *point, table=table: table[point]


def execute(
    system: System,
    rule: Text,
    reading: _Reading,
    args: tuple[Any, ...],
    but: Collection[str],
    goal: Text | None = None,
    values: tuple[Any, ...] = (),
) -> Example:
    """Run a rule in a state; it must be possible, and break the `goal`, if there is one.

    Raises:
        AssertionError: it does not.
    """
    _run_with(reading)
    after = reading.state.after()
    unmet = [name for name, condition in needs_of(rule, reading.state, after, args, but) if not condition]
    assert not unmet, (rule.name, unmet)
    assert goal is None or not goal.run(after, *values), (rule.name, goal)
    broken = tuple(each.name for each in system.conjuncts.values() if _failing(each, reading.universe, after))
    return Example(reading.state, after, args, broken)
