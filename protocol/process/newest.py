"""To make something once of what many robots of one process are told, or are to be told."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

Told = TypeVar("Told")
Made = TypeVar("Made")


def keeps_newest(make: Callable[[Told], Made]) -> Callable[[Told], Made]:
    """`make`, whose newest result is kept for the next call with equal arguments. Unlike
    `lru_cache` it hashes nothing: of a thousand robots that takes as long as to make the result."""
    kept: list[tuple[Told, Made]] = []

    def found(told: Told) -> Made:
        newest = kept[0] if kept else None  # looked at once: another thread may replace it
        if newest is None or (told is not newest[0] and told != newest[0]):
            newest = told, make(told)
            kept[:] = [newest]
        return newest[1]

    return found
