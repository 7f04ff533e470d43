"""Diagrams of states as sets of transitions, and a search for those that the code makes."""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Callable, Hashable, Iterable, Iterator
from typing import Any, Protocol

from docs.concepts.diagrams.render import FOLDER

Transition = tuple[str, str, str]  # from a state, by an event, to another one

_EDGE = re.compile(r"^ +(\S+) --> (\S+): (.*)$", re.MULTILINE)
_ANY = "Any"


def drawn(name: str) -> set[Transition]:
    """What `diagrams/<name>.mmd` shows: an edge's label begins with its events, up to a comma."""
    edges = _EDGE.findall((FOLDER / f"{name}.mmd").read_text())
    states = {state for start, end, _ in edges for state in (start, end)} - {_ANY, "[*]"}
    return {
        (state, event, end)
        for start, end, label in edges
        for event in label.partition(",")[0].split(" or ")
        for state in (states - {end} if start == _ANY else {start})
    }


class Model(Protocol):
    """Something real in a state, and what may happen to it."""

    @property
    def state(self) -> str:
        """As it is drawn."""

    @property
    def key(self) -> Hashable:
        """All that decides what may follow."""

    def events(self) -> Iterable[Any]:
        """What may happen."""

    def do(self, event: Any) -> Iterator[str]:
        """Let it happen, step by step; the names of the steps."""


def made(begin: Callable[[], Model], longest: int) -> set[Transition]:
    """All transitions within so many events of the beginning."""
    found: set[Transition] = set()
    known, paths = {begin().key}, deque[tuple[Any, ...]]([()])
    while paths:
        path = paths.popleft()
        for event in [*_led(begin, path).events()]:
            model = _led(begin, path)
            before = model.state
            for step in model.do(event):
                after = model.state
                if after != before:
                    found.add((before, step, after))
                before = after
            if model.key not in known and len(path) + 1 < longest:
                known.add(model.key)
                paths.append((*path, event))
    return found


def _led(begin: Callable[[], Model], path: Iterable[Any]) -> Model:
    """A model to which all of this has happened."""
    model = begin()
    for event in path:
        for _ in model.do(event):
            pass
    return model
