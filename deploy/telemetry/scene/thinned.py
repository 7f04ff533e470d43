"""A record of a whole run in bounded memory: the longer it lasts, the coarser it is kept."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")


class Thinned(Generic[T]):
    """At most `limit` entries (even), each standing for equally many of those appended.

    When full, neighbours are merged in pairs by `merge(earlier, later)`; the last entry may still be
    growing.
    """

    def __init__(self, limit: int, merge: Callable[[T, T], T]) -> None:
        self.items: list[T] = []
        self._limit, self._merge = limit + limit % 2, merge
        self._stride = 1  # appended entries per kept one
        self._count = 0

    def append(self, item: T) -> None:
        """Take one more entry."""
        if self._count % self._stride:
            self.items[-1] = self._merge(self.items[-1], item)
        else:
            self._make_room()
            self.items.append(item)
        self._count += 1

    def _make_room(self) -> None:
        if len(self.items) == self._limit:
            pairs = zip(self.items[::2], self.items[1::2], strict=True)
            self.items = [self._merge(earlier, later) for earlier, later in pairs]
            self._stride *= 2
