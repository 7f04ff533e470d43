"""From the choices of a run that shows something to simpler ones that still do, whichever run it is."""

from __future__ import annotations

from collections.abc import Callable, Sequence

_ENTRY = 12  # choices, at most, of one entry of a list
Shows = Callable[[Sequence[int]], Sequence[int] | None]


class Shrinker:
    """Looks for simpler choices: fewer ones, and of as many the smaller ones.

    Args:
        choices: of a run.
        shows: the choices that a run makes out of these, None if it does not show the same.
        tries: runs that there may be.

    Attributes:
        best: the simplest choices so far.
    """

    def __init__(self, choices: Sequence[int], shows: Shows, tries: int) -> None:
        self.best = list(choices)
        self._shows, self._left = shows, tries

    def exhaust(self) -> list[int]:
        """Try until nothing helps, or the tries are spent; returns the best."""
        before = None
        while before != self.best and self._left:
            before = self.best
            size = len(self.best) // 2
            while size:
                self._blocks(size)
                size //= 2
            self._counts()
            self._values()
        return self.best

    def _blocks(self, size: int) -> None:
        """Leave blocks out, or make all choices in them the simplest."""
        place = 0
        while place < len(self.best):
            head, tail = self.best[:place], self.best[place + size :]
            zeros = [0] * min(size, len(self.best) - place)
            if not (self._try(head + tail) or self._try(head + zeros + tail)):
                place += size

    def _counts(self) -> None:
        """Make a choice less by one that counts what follows, and leave the first of that out."""
        place = 0
        while place < len(self.best):
            head, count = self.best[:place], self.best[place]
            sizes = range(1, _ENTRY + 1 if count else 0)
            if not any(self._try([*head, count - 1, *self.best[place + 1 + size :]]) for size in sizes):
                place += 1

    def _values(self) -> None:
        """Make single choices smaller, by bisection."""
        place = 0
        while place < len(self.best):
            low, high = -1, self.best[place]
            while high - low > 1 and place < len(self.best):
                middle = (low + high) // 2
                if self._try([*self.best[:place], middle, *self.best[place + 1 :]]):
                    high = middle
                else:
                    low = middle
            place += 1

    def _try(self, choices: list[int]) -> bool:
        if not self._left or choices == self.best:
            return False
        self._left -= 1
        made = self._shows(choices)
        if made is None or (len(made), list(made)) >= (len(self.best), self.best):
            return False
        self.best = list(made)
        return True
