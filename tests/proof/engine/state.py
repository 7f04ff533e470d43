"""States: variables that are numbers, truth values or individuals, or maps to these.

A step of a system is written as if it ran: it reads the state before (`s.seen[life]`) and writes the one
after (`n.seen[life] = number`). What is not written stays. The same text runs on values, and on terms of a
solver, where a map that was written to is read as "the new value at that point, else the old one": no axiom
has to say what did not change.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import product
from typing import Any

import z3

from tests.proof.engine.logic import BOOL, INT, Sort, Term, every, is_symbolic, pick

EACH = object()  # in place of an argument: everywhere along it, as a function says


@dataclass(frozen=True)
class Variable:
    """One variable of a state.

    Attributes:
        over: sorts of the arguments, of a map.
        kind: of what it holds.
    """

    over: tuple[Sort, ...] = ()
    kind: Sort = INT


Schema = dict[str, Variable]


def number(*over: Sort) -> Variable:
    """An integer, or a map to integers."""
    return Variable(over, INT)


def flag(*over: Sort) -> Variable:
    """A truth value, or a map to them."""
    return Variable(over, BOOL)


class State:
    """Variables by name. Those named `side.name` are read as attributes of `state.side`."""

    schema: Schema

    def read(self, name: str, args: tuple[Term, ...]) -> Term:
        """What a variable holds."""
        raise NotImplementedError

    def write(self, name: str, args: tuple[Any, ...], value: Any) -> None:
        """Let a variable hold another value."""
        raise NotImplementedError

    def everywhere(self, sort: Sort, says: Callable[[Term], Term]) -> Term:
        """Whether something holds of all values of a sort."""
        raise NotImplementedError

    def __getitem__(self, name: str) -> Side:
        return Side(self, name)

    def __getattr__(self, name: str) -> Any:
        return _look(self, "", name)

    def __setattr__(self, name: str, value: Any) -> None:
        if name in type(self).__annotations__ or name.startswith("_"):
            object.__setattr__(self, name, value)
        else:
            self.write(name, (), value)


class Side:
    """The variables of a state whose names begin alike."""

    def __init__(self, state: State, name: str) -> None:
        object.__setattr__(self, "_state", state)
        object.__setattr__(self, "_name", name)

    def __getattr__(self, name: str) -> Any:
        return _look(self._state, f"{self._name}.", name)

    def __setattr__(self, name: str, value: Any) -> None:
        self._state.write(f"{self._name}.{name}", (), value)

    def at(self, *args: Term) -> At:
        """What its maps hold at a point, as attributes."""
        return At(self, args)


class At:
    """The maps of one side at one point: `side.at(life).seen` is `side.seen[life]`."""

    def __init__(self, side: Side, args: tuple[Term, ...]) -> None:
        object.__setattr__(self, "_side", side)
        object.__setattr__(self, "_args", args)

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._side, name)
        if not isinstance(found, Map):
            return found
        return (
            found[self._args] if found.arity == len(self._args) else Map(found.state, found.name, self._args)
        )

    def __setattr__(self, name: str, value: Any) -> None:
        found = getattr(self._side, name)
        rest = (EACH,) * (found.arity - len(self._args))
        found[(*self._args, *rest)] = value


class Map:
    """A variable that is a map; its first arguments may be given already."""

    def __init__(self, state: State, name: str, first: tuple[Term, ...] = ()) -> None:
        self.state, self.name, self.first = state, name, first

    @property
    def arity(self) -> int:
        return len(self.state.schema[self.name].over) - len(self.first)

    def __getitem__(self, args: Any) -> Term:
        return self.state.read(self.name, (*self.first, *_tuple(args)))

    def __setitem__(self, args: Any, value: Any) -> None:
        self.state.write(self.name, (*self.first, *_tuple(args)), value)


def _look(state: State, prefix: str, name: str) -> Any:
    full = prefix + name
    variable = state.schema.get(full)
    if variable is None:
        if prefix or name.startswith("_"):
            raise AttributeError(full)
        return Side(state, full)
    return Map(state, full) if variable.over else state.read(full, ())


def _tuple(args: Any) -> tuple[Any, ...]:
    return args if isinstance(args, tuple) else (args,)


class Symbolic(State):
    """A state of which nothing is known, or what steps make of it.

    Args:
        schema: its variables.
        written: what was written to it, oldest first: where, and the value or a function of what is EACH.
    """

    schema: Schema

    def __init__(
        self, schema: Schema, written: dict[str, list[tuple[tuple[Any, ...], Any]]] | None = None
    ) -> None:
        self.schema = schema
        self._written = written or {}

    def after(self) -> Symbolic:
        """A state that is the same so far."""
        return Symbolic(self.schema, {name: list(writes) for name, writes in self._written.items()})

    def read(self, name: str, args: tuple[Term, ...]) -> Term:
        variable = self.schema[name]
        term = base(name, variable)(*args)
        for where, value in self._written.get(name, ()):
            pairs = [(one, arg) for one, arg in zip(where, args, strict=True) if one is not EACH]
            wild = [arg for one, arg in zip(where, args, strict=True) if one is EACH]
            new = _lifted(value(*wild) if callable(value) else value, variable.kind)
            if all(_is_same(one, arg) for one, arg in pairs):
                term = new
            elif not any(_differ(one, arg) for one, arg in pairs):
                term = pick(every(*[one == arg for one, arg in pairs]), new, term)
        return term

    def everywhere(self, sort: Sort, says: Callable[[Term], Term]) -> Term:
        value = z3.FreshConst(sort.z3)
        return z3.ForAll([value], says(value))

    def write(self, name: str, args: tuple[Any, ...], value: Any) -> None:
        assert len(args) == len(self.schema[name].over), name
        self._written.setdefault(name, []).append((args, value))


def base(name: str, variable: Variable) -> z3.FuncDeclRef:
    """What the solver calls a variable."""
    return z3.Function(name, *[sort.z3 for sort in variable.over], variable.kind.z3)


def _lifted(value: Term, kind: Sort) -> z3.ExprRef:
    if is_symbolic(value):
        return value
    return z3.BoolVal(value) if kind == BOOL else z3.IntVal(value)


def _is_same(one: Term, other: Term) -> bool:
    if is_symbolic(one) and is_symbolic(other):
        return z3.eq(one, other)
    return False if is_symbolic(one) or is_symbolic(other) else one == other


def _differ(one: Term, other: Term) -> bool:
    return not is_symbolic(one) and not is_symbolic(other) and one != other


class Concrete(State):
    """A state of values.

    Args:
        schema: its variables.
        universe: all values of each sort; a function that is written along EACH is asked at these.
        tables: what each variable holds, by arguments; elsewhere the default of its sort.
    """

    schema: Schema
    universe: dict[Sort, Iterable[Any]]
    tables: dict[str, dict[tuple[Any, ...], Any]]

    def __init__(
        self,
        schema: Schema,
        universe: dict[Sort, Iterable[Any]],
        tables: dict[str, dict[tuple[Any, ...], Any]] | None = None,
    ) -> None:
        self.schema, self.universe, self.tables = schema, universe, tables or {}

    def after(self) -> Concrete:
        """A state that is the same so far."""
        return Concrete(
            self.schema, self.universe, {name: dict(table) for name, table in self.tables.items()}
        )

    def read(self, name: str, args: tuple[Term, ...]) -> Term:
        found = self.tables.get(name, {}).get(args)
        return self.schema[name].kind.default if found is None else found

    def everywhere(self, sort: Sort, says: Callable[[Term], Term]) -> Term:
        return all(says(value) for value in self.universe[sort])

    def write(self, name: str, args: tuple[Any, ...], value: Any) -> None:
        table = self.tables.setdefault(name, {})
        over = self.schema[name].over
        for point in product(
            *[self.universe[sort] if arg is EACH else (arg,) for arg, sort in zip(args, over, strict=True)]
        ):
            wild = [each for each, arg in zip(point, args, strict=True) if arg is EACH]
            table[point] = value(*wild) if callable(value) else value
