"""Containers of the kernel with symbolic content: lists of any length, fields that may be None."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from functools import cache, cached_property
from typing import Any

from tests.proof.symbolic import expression


class Frame:
    """Frame condition of a rule: a ledger or robot and all objects in it, by their paths. The content of a
    replaced object is not compared: the state, or a claim, covers it.

    Args:
        thing: the ledger or robot, before the rule.
        may_change: a pattern of paths.
    """

    def __init__(self, thing: Any, may_change: str) -> None:
        self._thing, self._may_change = thing, may_change
        self._before = dict(_places(thing))

    @property
    def changed(self) -> dict[tuple[str, ...], tuple[Any, Any]]:
        """Paths of replaced objects, with the objects before and after."""
        before, now = self._before, dict(_places(self._thing))
        found = {place: (before.get(place, self), now.get(place, self)) for place in before | now}
        found = {place: both for place, both in found.items() if both[0] is not both[1]}
        within = {place for place in found if any(place[:end] in found for end in range(len(place)))}
        return {place: both for place, both in found.items() if place not in within}

    @property
    def holds(self) -> bool:
        """Whether nothing else has changed; a `LazyOptional` may have been read."""
        return all(
            re.fullmatch(self._may_change, "/".join(place))
            or (isinstance(before, LazyOptional) and now is before.found())
            for place, (before, now) in self.changed.items()
        )


def _places(thing: Any, place: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    yield place, thing
    inner = thing if isinstance(thing, dict) else {}
    if isinstance(thing, SymbolicList):
        inner = {"appended": thing.appended}
    elif type(thing).__module__.startswith("protocol.kernel"):
        inner = vars(type(thing)).get("optional", {}) | vars(thing)
    for name, each in inner.items():
        yield from _places(each, (*place, name if isinstance(name, str) else expression(name).sexpr()))


class LazyOptional(cached_property[Any]):
    """A field that is None unless a condition holds, which is evaluated when a rule first reads the field."""

    def __init__(self, value: Any, condition: Any) -> None:
        self.found = cache(lambda: value if condition else None)
        super().__init__(lambda _: self.found())


def with_optional(made: Any, **fields: tuple[Any, Any]) -> Any:
    """An object with some fields that are None unless a condition holds."""
    kind, optional = type(made), {name: LazyOptional(*field) for name, field in fields.items()}
    also = {"optional": optional, "__module__": kind.__module__}
    made.__class__ = type(kind.__name__, (kind,), optional | also)
    for name in fields:
        delattr(made, name)
    return made


class SymbolicList:
    """A list of any length, of which loops treat all elements alike (`language.py`): those that the solver
    distinguishes, and those appended."""

    def __init__(self, elements: Callable[[], Iterable[Any]]) -> None:
        self._elements = elements
        self.appended: list[Any] = []

    def __iter__(self) -> Iterator[Any]:
        return iter([*self._elements(), *self.appended])

    def __getitem__(self, index: int) -> Any:
        return list(self)[index]

    def append(self, element: Any) -> None:
        self.appended = [*self.appended, element]
