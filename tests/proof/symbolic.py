"""Every way through a function that compares terms of the solver."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any
from unittest.mock import patch

import z3


class Impossible(Exception):  # noqa: N818  # no error
    """No state leads this way."""


_judges: list[Way | Execution] = []


def expression(value: object) -> Any:
    """The solver's term for what the product says."""
    if isinstance(value, z3.ExprRef):
        return value
    assert isinstance(value, int), value
    return z3.BoolVal(value) if isinstance(value, bool) else z3.IntVal(value)


def require(holds: object, name: str) -> None:
    """In place of the kernel's: a precondition is assumed."""
    _judges[-1].require(expression(holds), name)


class Way:
    """One way through a function.

    Args:
        solver: which knows what is given.
        begins: answers to the first questions, where there is a choice.
        without: the precondition that is left out.

    Attributes:
        answers: to all questions where there was a choice.
        conditions: under which the function goes this way.
        result: of the function.
    """

    def __init__(self, solver: z3.Solver, begins: Sequence[bool], without: str) -> None:
        self._solver, self._begins, self._without = solver, begins, without
        self._known: dict[int, tuple[z3.BoolRef, bool]] = {}
        self.answers: list[bool] = []
        self.conditions: list[z3.BoolRef] = []
        self.others: list[list[bool]] = []
        self.result: Any = None

    def answer(self, of: z3.BoolRef) -> bool:
        """Whether a condition holds, that is branched on."""
        of = z3.simplify(of)
        if z3.is_true(of) or z3.is_false(of):
            return bool(z3.is_true(of))
        if of.get_id() not in self._known:
            self._known[of.get_id()] = (of, self._choose(of))
        return self._known[of.get_id()][1]

    def _choose(self, of: z3.BoolRef) -> bool:
        if len(self.answers) < len(self._begins):
            chosen = self._begins[len(self.answers)]
        else:
            chosen = self._may_be(of)
            if not self._may_be(z3.Not(of)):
                if not chosen:
                    raise Impossible
            elif chosen:
                self.others.append([*self.answers, False])
        self.answers.append(chosen)
        self.conditions.append(of if chosen else z3.Not(of))
        return chosen

    def _may_be(self, condition: z3.BoolRef) -> bool:
        return bool(self._solver.check(*self.conditions, condition) != z3.unsat)

    def require(self, of: z3.BoolRef, name: str) -> None:
        """A precondition."""
        if name != self._without:
            of = z3.simplify(of)
            if z3.is_false(of):
                raise Impossible
            self.conditions.append(of)


def ways(run: Callable[[], object], given: Sequence[z3.BoolRef], without: str = "") -> Iterator[Way]:
    """Every way through `run` that the assumptions allow, with a precondition left out or none."""
    solver = z3.Solver()
    solver.add(*given)
    waiting: list[list[bool]] = [[]]
    while waiting:
        way = Way(solver, waiting.pop(), without)
        try:
            way.result = judged(way, run)
        except Impossible:
            pass
        else:
            if solver.check(*way.conditions) != z3.unsat:
                yield way
        waiting += way.others


class Execution:
    """A function run on the numbers of a model: each comparison has the one answer that it has there.

    Attributes:
        refused: preconditions that do not hold.
    """

    def __init__(self, model: z3.ModelRef) -> None:
        self._model = model
        self.refused: list[str] = []

    def answer(self, of: z3.BoolRef) -> bool:
        return bool(z3.is_true(self._model.eval(of, model_completion=True)))

    def require(self, of: z3.BoolRef, name: str) -> None:
        if not self.answer(of):
            self.refused.append(name)


def judged(judge: Way | Execution, run: Callable[[], Any]) -> Any:
    """What a function returns if one judge says of each condition whether it holds; a dictionary of terms
    asks which of them are equal.
    """

    def ask(condition: z3.BoolRef) -> bool:
        return judge.answer(condition)

    _judges.append(judge)
    try:
        with patch.object(z3.BoolRef, "__bool__", ask), patch.object(z3.ExprRef, "__hash__", lambda _: 0):
            return run()
    finally:
        _judges.pop()
