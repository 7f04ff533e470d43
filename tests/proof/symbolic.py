"""Symbolic execution: every feasible path through a function whose conditions are terms of the solver."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any
from unittest.mock import patch

import z3


class InfeasibleError(Exception):
    """No state takes this path."""


_evaluators: list[Path | ConcreteRun] = []


def expression(value: object) -> Any:
    """The solver's term for a value of the product."""
    if isinstance(value, z3.ExprRef):
        return value
    assert isinstance(value, int), value
    return z3.BoolVal(value) if isinstance(value, bool) else z3.IntVal(value)


def require(holds: object, name: str) -> None:
    """Replaces the kernel's `require`: a precondition is assumed."""
    _evaluators[-1].require(expression(holds), name)


class Path:
    """One path through a function.

    Args:
        solver: has the assumptions.
        prefix: the first decisions.
        without: the precondition to omit.

    Attributes:
        decisions: at all branches that are possible both ways.
        conditions: the path condition.
        alternatives: prefixes of paths that leave this one.
        result: of the function.
    """

    def __init__(self, solver: z3.Solver, prefix: Sequence[bool], without: str) -> None:
        self._solver, self._prefix, self._without = solver, prefix, without
        self._known: dict[int, tuple[z3.BoolRef, bool]] = {}
        self.decisions: list[bool] = []
        self.conditions: list[z3.BoolRef] = []
        self.alternatives: list[list[bool]] = []
        self.result: Any = None

    def answer(self, of: z3.BoolRef) -> bool:
        """The value of a branch condition on this path."""
        of = z3.simplify(of)
        if z3.is_true(of) or z3.is_false(of):
            return bool(z3.is_true(of))
        if of.get_id() not in self._known:
            self._known[of.get_id()] = (of, self._decide(of))
        return self._known[of.get_id()][1]

    def _decide(self, of: z3.BoolRef) -> bool:
        if len(self.decisions) < len(self._prefix):
            decision = self._prefix[len(self.decisions)]
        else:
            decision = self._is_feasible(of)
            if not self._is_feasible(z3.Not(of)):
                if not decision:
                    raise InfeasibleError
            elif decision:
                self.alternatives.append([*self.decisions, False])
        self.decisions.append(decision)
        self.conditions.append(of if decision else z3.Not(of))
        return decision

    def _is_feasible(self, condition: z3.BoolRef) -> bool:
        return bool(self._solver.check(*self.conditions, condition) != z3.unsat)

    def require(self, of: z3.BoolRef, name: str) -> None:
        """Assume a precondition."""
        if name != self._without:
            of = z3.simplify(of)
            if z3.is_false(of):
                raise InfeasibleError
            self.conditions.append(of)


def paths(run: Callable[[], object], given: Sequence[z3.BoolRef], without: str = "") -> Iterator[Path]:
    """Every feasible path through `run` under assumptions, with all preconditions but one, or all."""
    solver = z3.Solver()
    solver.add(*given)
    waiting: list[list[bool]] = [[]]
    while waiting:
        path = Path(solver, waiting.pop(), without)
        try:
            path.result = evaluated(path, run)
        except InfeasibleError:
            pass
        else:
            if solver.check(*path.conditions) != z3.unsat:
                yield path
        waiting += path.alternatives


class ConcreteRun:
    """A run of a function on the numbers of a model, which gives each condition its value.

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


def evaluated(evaluator: Path | ConcreteRun, run: Callable[[], Any]) -> Any:
    """The result of a function whose conditions `evaluator` answers; a dictionary with terms as keys asks
    which of them are equal."""

    def ask(condition: z3.BoolRef) -> bool:
        return evaluator.answer(condition)

    _evaluators.append(evaluator)
    try:
        with patch.object(z3.BoolRef, "__bool__", ask), patch.object(z3.ExprRef, "__hash__", lambda _: 0):
            return run()
    finally:
        _evaluators.pop()
