"""Contacts as the plant itself saw them: a second judge beside the geometry of `world.judge.contacts`."""

from __future__ import annotations

from collections.abc import Sequence

Pair = tuple[int, int]


class Touches:
    """All contacts that a plant has reported, each once, in the order in which they began.

    Attributes:
        all: tick and pair of ids.
    """

    def __init__(self) -> None:
        self.all: list[tuple[int, Pair]] = []
        self._present: set[Pair] = set()

    def add(self, tick: int, pairs: Sequence[Pair]) -> None:
        """Take note of the pairs that touched in a tick."""
        present = set(pairs)
        self.all += ((tick, pair) for pair in sorted(present - self._present))
        self._present = present
