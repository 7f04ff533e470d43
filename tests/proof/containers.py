"""What the kernel keeps, of which the solver knows a part: lists, fields that may be None."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import cache, cached_property
from operator import itemgetter
from typing import Any


class Frame:
    """What objects were: all of their fields that no rule names keep the very same values, fields that the
    state has no number for as well.

    Args:
        things: each with the names of the fields that may change; a dictionary has entries.
    """

    def __init__(self, *things: tuple[Any, str]) -> None:
        self._things = things
        self._before = self._now()

    def _now(self) -> list[Any]:
        return [
            each
            for thing, changing in self._things
            for item in (thing.items() if isinstance(thing, dict) else _fields_of(thing))
            if not changing or item[0] not in changing.split()
            for each in (*item, getattr(item[1], "appended", ()))
        ]

    @property
    def holds(self) -> bool:
        """Whether nothing else has changed."""
        now = self._now()
        return len(now) == len(self._before) and all(map(_is_kept, self._before, now))


def _fields_of(thing: Any) -> list[tuple[str, Any]]:
    return sorted((vars(type(thing)).get("optional", {}) | vars(thing)).items(), key=itemgetter(0))


def _is_kept(before: Any, now: Any) -> bool:
    return now is before or (isinstance(before, Optional) and now is before.found())


class Optional(cached_property[Any]):
    """A field that is None unless a condition holds, which is asked when a rule first looks at the field."""

    def __init__(self, value: Any, condition: Any) -> None:
        self.found = cache(lambda: value if condition else None)
        super().__init__(lambda _: self.found())


def with_optional(made: Any, **fields: tuple[Any, Any]) -> Any:
    """An object with fields that have a value under a condition each."""
    optional = {name: Optional(*field) for name, field in fields.items()}
    made.__class__ = type(type(made).__name__, (type(made),), {**optional, "optional": optional})
    for name in fields:
        delattr(made, name)
    return made


class Some:
    """A list of any length: the elements that the solver can tell from others, which are all treated alike
    (`language.py`), and what is appended.
    """

    def __init__(self, elements: Callable[[], Iterable[Any]]) -> None:
        self._elements = elements
        self.appended: list[Any] = []

    def __iter__(self) -> Iterator[Any]:
        return iter([*self._elements(), *self.appended])

    def __getitem__(self, index: int) -> Any:
        return list(self)[index]

    def append(self, element: Any) -> None:
        self.appended = [*self.appended, element]
