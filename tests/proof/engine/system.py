"""A transition system as text: variables, rules, what is known of relations, and conjuncts of an invariant.

A rule is a generator: it first yields what it needs, each as a name and a condition, then writes the state
after. A conjunct returns what holds of every value of its parameters; its docstring says it in words.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, field, replace
from typing import Any

from tests.proof.engine.logic import Relation, Sort, Term
from tests.proof.engine.state import Schema, State


@dataclass(frozen=True)
class Text:
    """A rule, conjunct or axiom, for given sides.

    Attributes:
        name: of the function, and of the side that it is about.
        says: its sentence.
        run: the function, but for its sides.
        parameters: sorts of the others, by name.
        starts: whether it is a rule that needs no state before it.
    """

    name: str
    says: str
    run: Callable[..., Any]
    parameters: dict[str, Sort]
    starts: bool = False


@dataclass
class System:
    """All texts of a transition system.

    Attributes:
        schema: variables.
        relations: predicates of which only the axioms are known.
        rules, conjuncts, axioms: see `Text`.
    """

    schema: Schema
    relations: tuple[Relation, ...] = ()
    rules: dict[str, Text] = field(default_factory=dict)
    conjuncts: dict[str, Text] = field(default_factory=dict)
    axioms: dict[str, Text] = field(default_factory=dict)

    def rule(self, *sides: tuple[str, ...]) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
        """Register a rule, once for each of the `sides`, which are its first arguments after both states."""
        return self._register(self.rules, 2, sides)

    def start(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Register the rule that makes the first state, its only one."""
        self._register(self.rules, 1, ())(function)
        text = self.rules[function.__name__]
        run = text.run
        self.rules[text.name] = replace(text, run=lambda _, after, *args: run(after, *args), starts=True)
        return function

    def conjunct(self, *sides: tuple[str, ...]) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
        """Register a conjunct of the invariant likewise; its sides come after the state."""
        return self._register(self.conjuncts, 1, sides)

    def axiom(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Register what is known of relations."""
        return self._register(self.axioms, 0, ())(function)

    def _register(
        self, kept: dict[str, Text], states: int, sides: tuple[tuple[str, ...], ...]
    ) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
        def register(function: Callable[..., Any]) -> Callable[..., Any]:
            for each in sides or ((),):
                name = function.__name__ + (f" ({each[0]})" if each else "")
                names = list(inspect.signature(function).parameters)[states + len(each) :]
                sorts = inspect.get_annotations(function, eval_str=True)
                assert name not in kept, name
                kept[name] = Text(
                    name,
                    " ".join((inspect.getdoc(function) or "").split()),
                    _bound(function, states, each),
                    {parameter: sorts[parameter] for parameter in names},
                )
            return function

        return register


def _bound(function: Callable[..., Any], states: int, sides: tuple[str, ...]) -> Callable[..., Any]:
    if not sides:
        return function
    return lambda *args: function(*args[:states], *sides, *args[states:])


Need = tuple[str, Term]


def needs_of(
    rule: Text, before: State, after: State, args: tuple[Term, ...], but: Collection[str] = ()
) -> list[Need]:
    """Run a rule: what it needs, but for what is left out; `after` is the state after it."""
    steps: Iterator[Need] = rule.run(before, after, *args)
    return [need for need in steps if need[0] not in but]
