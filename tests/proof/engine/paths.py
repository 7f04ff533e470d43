"""Read a program's source with a solver: run it on symbols, once for each way through it.

A comparison of symbols is a `Truth`; wherever the program asks whether it holds, one run goes on with yes,
another with no, if the solver finds either possible. What a run leaves behind is true under what it was told.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any, ClassVar

import z3

from tests.proof.engine.logic import Term, is_symbolic


class Path:
    """One way through a program: what it was told so far."""

    current: ClassVar[Path]

    def __init__(self, assumed: Iterable[z3.BoolRef], answers: list[bool]) -> None:
        self.told: list[z3.BoolRef] = []
        self.open: list[list[bool]] = []  # other ways, as answers up to where they part
        self._answers, self._given = answers, 0
        self._solver = z3.SimpleSolver()
        self._solver.add(*assumed)

    def decide(self, term: z3.BoolRef) -> bool:
        """Whether this holds, on this way."""
        if self._given < len(self._answers):
            answer = self._answers[self._given]
        else:
            possible = [
                each for each in (True, False) if self._solver.check(term if each else z3.Not(term)) == z3.sat
            ]
            answer = possible[0]
            if len(possible) > 1:
                self.open.append([*self._answers[: self._given], not answer])
            self._answers = [*self._answers[: self._given], answer]
        self._given += 1
        self.told.append(term if answer else z3.Not(term))
        self._solver.add(self.told[-1])
        return answer


def decide(term: Term) -> bool:
    """Whether a term holds, on the present way."""
    return Path.current.decide(term) if is_symbolic(term) else bool(term)


def ways(run: Callable[[], Any], assumed: Iterable[z3.BoolRef]) -> Iterator[tuple[list[z3.BoolRef], Any]]:
    """Run a program in all ways: what each was told, and what came out."""
    known = list(assumed)
    waiting: list[list[bool]] = [[]]
    while waiting:
        Path.current = path = Path(known, waiting.pop())
        result = run()
        waiting += path.open
        yield path.told, result


class Truth:
    """A symbol for a truth value."""

    def __init__(self, term: Term) -> None:
        self.term = term

    def __bool__(self) -> bool:
        return decide(self.term)


class Symbol:
    """A symbol for a number, or for one of several words, each of which stands for a number."""

    def __init__(self, term: Term, words: tuple[str, ...] = ()) -> None:
        self.term, self.words = term, words

    def _of(self, other: Any) -> Term:
        if isinstance(other, str):
            return self.words.index(other)
        return other.term if isinstance(other, Symbol) else other

    def __eq__(self, other: object) -> Truth:  # type: ignore[override]  # a program only asks whether it holds
        return Truth(self.term == self._of(other))

    def __ne__(self, other: object) -> Truth:  # type: ignore[override]
        return Truth(self.term != self._of(other))

    def __lt__(self, other: Any) -> Truth:
        return Truth(self.term < self._of(other))

    def __le__(self, other: Any) -> Truth:
        return Truth(self.term <= self._of(other))

    def __gt__(self, other: Any) -> Truth:
        return Truth(self.term > self._of(other))

    def __ge__(self, other: Any) -> Truth:
        return Truth(self.term >= self._of(other))

    def __add__(self, other: Any) -> Symbol:
        return Symbol(self.term + self._of(other))

    def __sub__(self, other: Any) -> Symbol:
        return Symbol(self.term - self._of(other))

    def __bool__(self) -> bool:
        return decide(self.term != 0)

    def __hash__(self) -> int:
        return id(self)


def term_of(value: Any, words: tuple[str, ...] = ()) -> Term:
    """What a program left behind, for the solver."""
    if isinstance(value, Truth | Symbol):
        return value.term
    return words.index(value) if isinstance(value, str) else value
