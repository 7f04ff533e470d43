"""What Ctrl-C must not cut short, and what it ends in good order."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType

from protocol.process.signals import ENDING, heard_by


@contextmanager
def undisturbed() -> Iterator[None]:
    """Inside, Ctrl-C and its like do nothing: for the end of a run, which takes some seconds at most."""
    with heard_by(signal.SIG_IGN):
        yield


@contextmanager
def counted() -> Iterator[Callable[[], int]]:
    """Inside, what raises KeyboardInterrupt elsewhere is counted: what this gives says how often it came.

    For a loop that looks at it and ends: an exception might come between any two of its steps. It is raised
    only if there was another one since the count was looked at, for then something holds up the loop.
    """
    before = {number: handler for number in ENDING if callable(handler := signal.getsignal(number))}
    count, seen = 0, 0

    def note(number: int, frame: FrameType | None) -> None:
        nonlocal count
        count += 1
        with suppress(KeyboardInterrupt):
            before[signal.Signals(number)](number, frame)
        if count > seen + 1:
            raise KeyboardInterrupt

    def look() -> int:
        nonlocal seen
        seen = count
        return count

    with heard_by(note, before):
        yield look
