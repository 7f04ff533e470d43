"""Signals that ask a process to end, and who hears of them for a while."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any, Final

Handler = Callable[[int, FrameType | None], Any] | int | signal.Handlers | None

ENDING: Final = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)  # Ctrl-C, a supervisor, a terminal that closes


@contextmanager
def heard_by(handler: Handler, numbers: Iterable[int] = ENDING) -> Iterator[None]:
    """Inside, `handler` hears of these signals; afterwards whoever did before, whatever comes meanwhile.

    Nothing changes in a thread that is not the main one, which alone hears of signals, nor for a signal
    whose handler is not Python's. A handler that was set inside stays: who ends at the first signal has
    further ones ignored, and the first may come as handlers change.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = [(number, signal.getsignal(number)) for number in numbers]
    before = [(number, earlier) for number, earlier in before if earlier is not None]
    try:
        for number, _ in before:
            signal.signal(number, handler)
        yield
    finally:
        _give_back(before, handler)


def _give_back(before: list[tuple[int, Handler]], handler: Handler) -> None:
    """Each signal to its handler, the last first, though one of them raise before all have theirs."""
    raised: BaseException | None = None
    while before:
        try:
            while before:
                number, earlier = before[-1]
                if signal.getsignal(number) == handler:
                    signal.signal(number, earlier)
                before.pop()
        except BaseException as error:  # noqa: BLE001  # whatever a handler raises
            raised = error
    if raised is not None:
        raise raised
