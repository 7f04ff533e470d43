"""Python's garbage collector beside a fleet in one process, whose ticks leave no cycles behind."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock
from typing import Final

_YOUNG: Final = 1_000_000  # objects, instead of 700: messages of a tick are many, and are gone by themselves
_GROWTH: Final = 1.25  # of all objects until they are looked through: what Python's own collector waits for


@contextmanager
def seldom_collecting() -> Iterator[None]:
    """Inside, what is there already is not looked at, and what comes seldom: of 1000 robots that is a quarter
    of a tick. Threads may be inside together: what was before is back when the last has left."""
    _ASIDE.enter()
    try:
        yield
    finally:
        _ASIDE.leave()


class _Aside:
    """What is there before a run. Looking through all of it takes as long as a short run, where much has been
    imported: only what is young is, until there is a quarter more than all that was left last time."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._inside = 0
        self._before = gc.get_threshold()
        self._left = 0

    def enter(self) -> None:
        with self._lock:
            if not self._inside:
                self._before = gc.get_threshold()
                self._put()
                gc.set_threshold(_YOUNG, *self._before[1:])
            self._inside += 1

    def leave(self) -> None:
        with self._lock:
            self._inside -= 1
            if not self._inside:
                gc.set_threshold(*self._before)
                gc.unfreeze()

    def _put(self) -> None:
        gc.collect(1)
        gc.freeze()
        if gc.get_freeze_count() > _GROWTH * self._left:
            gc.unfreeze()
            gc.collect()
            gc.freeze()
            self._left = gc.get_freeze_count()


_ASIDE: Final = _Aside()
