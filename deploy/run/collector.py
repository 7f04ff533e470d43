"""Python's garbage collector beside a fleet in one process, whose ticks leave no cycles behind."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

_YOUNG: Final = 100_000  # objects, instead of 700: messages of a tick are many, and are gone by themselves


@contextmanager
def seldom_collecting() -> Iterator[None]:
    """Inside, what is there already is not looked at, and what comes seldom: of 1000 robots that is a quarter
    of a tick."""
    before = gc.get_threshold()
    gc.collect()
    gc.freeze()
    gc.set_threshold(_YOUNG, *before[1:])
    try:
        yield
    finally:
        gc.set_threshold(*before)
        gc.unfreeze()
