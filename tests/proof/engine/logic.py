"""Terms that a solver and an interpreter read alike: Python values, or z3 expressions in their place."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import z3

Term = Any  # an int, a bool or the name of an individual; or an expression of z3


@dataclass(frozen=True)
class Sort:
    """A kind of values. Integers are unbounded; of an uninterpreted sort nothing is known but equality."""

    name: str

    @property
    def z3(self) -> z3.SortRef:
        """The same for the solver."""
        return {"Int": z3.IntSort, "Bool": z3.BoolSort}.get(self.name, lambda: z3.DeclareSort(self.name))()

    @property
    def default(self) -> Term:
        """What a variable holds before anything was written to it."""
        return {"Int": 0, "Bool": False}.get(self.name, f"{self.name}0")


INT, BOOL = Sort("Int"), Sort("Bool")


def is_symbolic(term: Term) -> bool:
    """Whether a term is the solver's."""
    return isinstance(term, z3.ExprRef)


def every(*terms: Term) -> Term:
    """All of these hold."""
    if any(is_symbolic(term) for term in terms):
        return z3.And(*terms) if len(terms) > 1 else terms[0]
    return all(terms)


def some(*terms: Term) -> Term:
    """At least one of these holds."""
    if any(is_symbolic(term) for term in terms):
        return z3.Or(*terms) if len(terms) > 1 else terms[0]
    return any(terms)


def no(term: Term) -> Term:
    """This does not hold."""
    return z3.Not(term) if is_symbolic(term) else not term


def implies(condition: Term, conclusion: Term) -> Term:
    """The conclusion holds wherever the condition does."""
    if is_symbolic(condition) or is_symbolic(conclusion):
        return z3.Implies(condition, conclusion)
    return not condition or conclusion


def pick(condition: Term, one: Term, other: Term) -> Term:
    """The one where the condition holds, elsewhere the other."""
    if not is_symbolic(condition):
        return one if condition else other
    if not is_symbolic(one) and not is_symbolic(other) and one == other:
        return one
    return z3.If(condition, one, other)


@dataclass(frozen=True)
class Relation:
    """An uninterpreted predicate; what is known of it are a system's axioms."""

    name: str
    over: tuple[Sort, ...]

    def __call__(self, *args: Term) -> Term:
        """Whether it holds; an interpreter looks it up in the table that it runs with."""
        if any(is_symbolic(each) for each in args):
            return self.z3(*args)
        return TABLES[self.name](*args)

    @property
    def z3(self) -> z3.FuncDeclRef:
        """The same for the solver."""
        return z3.Function(self.name, *[sort.z3 for sort in self.over], z3.BoolSort())


TABLES: dict[str, Callable[..., bool]] = {}  # of the state that is executed at present, by relation
