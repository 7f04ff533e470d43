"""What Ctrl-C must not cut short, and what it ends in good order."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType

_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@contextmanager
def undisturbed() -> Iterator[None]:
    """Inside, Ctrl-C and its like do nothing: for the end of a run, which takes some seconds at most."""
    if threading.current_thread() is not threading.main_thread():  # signals are heard by that one alone
        yield
        return
    before = {number: signal.signal(number, signal.SIG_IGN) for number in _SIGNALS}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def counted() -> Iterator[Callable[[], int]]:
    """Inside, what raises KeyboardInterrupt elsewhere is counted: what this gives says how often it came.

    For a loop that looks at it and ends: an exception might come between any two of its steps.
    """
    if threading.current_thread() is not threading.main_thread():
        yield lambda: 0
        return
    before = {number: signal.getsignal(number) for number in _SIGNALS}
    count = 0

    def note(number: int, frame: FrameType | None) -> None:
        nonlocal count
        count += 1
        handler = before[signal.Signals(number)]
        with suppress(KeyboardInterrupt):
            if callable(handler):
                handler(number, frame)

    heard = [number for number in _SIGNALS if callable(before[number])]
    try:
        for number in heard:
            signal.signal(number, note)
        yield lambda: count
    finally:
        for number in reversed(heard):
            signal.signal(number, before[number])
