"""A signal that asks this process to end, as an event: it is noted and wakes waits, and raises nothing.

Python executes the handler of a signal between any two instructions of the main thread, so an exception from
it could be lost in a callback, or leave anything incomplete. Loops and waits check `STOP` instead, and end in
a consistent state: by themselves, or by `Stopped`, which only the documented waits raise.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from queue import Empty, SimpleQueue
from types import FrameType
from typing import Any, Final, NoReturn

ENDING: Final = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)  # Ctrl-C, a supervisor, a terminal that closes
_HELD_UP = 2.0  # s without a check of a signal after which another one has its original effect


class Stopped(Exception):  # noqa: N818  # not an error
    """A wait was given up because this process was asked to end."""


class StopSignal:
    """Whether a signal has asked this process to end. Handlers belong to a process, so there is one: `STOP`.

    If a signal is not checked for two seconds, the next one has its original effect, since other code may
    hang, such as a law of the user.
    """

    def __init__(self) -> None:
        self.number = 0  # of the first signal, 0 without one
        self.count = 0  # of signals
        self._unseen: float | None = None  # s, monotonic: time of an unchecked signal
        self._before: dict[int, Any] = {}  # handlers
        self._calls: list[Callable[[], object]] = []

    @property
    def requested(self) -> bool:
        """Whether this process is to end."""
        if not self.number:
            return False
        self._unseen = None
        return True

    @property
    def status(self) -> int:
        """The exit status for the signal: 130 for Ctrl-C, 143 for SIGTERM; 0 without one."""
        return 128 + self.number if self.requested else 0

    def check(self) -> None:
        """Raise Stopped, to abandon the present wait, if this process is to end."""
        if self.requested:
            raise Stopped

    def wait(self, timeout: float | None = None) -> bool:
        """Wait for a signal, at most `timeout` s (default: for ever); returns whether to end."""
        signals: SimpleQueue[None] = SimpleQueue()
        with self.calling(partial(signals.put, None)), suppress(Empty):
            signals.get(timeout=timeout)
        return self.requested

    @contextmanager
    def calling(self, stop: Callable[[], object]) -> Iterator[None]:
        """Inside, each signal calls `stop`, in the main thread and between any two instructions; also an
        earlier signal, at once. `SimpleQueue.put` is made for that.
        """
        self.call(stop)
        try:
            yield
        finally:
            self.call_no_more(stop)

    def call(self, stop: Callable[[], object]) -> None:
        """As `calling`, until `call_no_more`."""
        self._calls.append(stop)
        if self.number:
            stop()

    def call_no_more(self, stop: Callable[[], object]) -> None:
        """The reverse of `call`; no effect without it."""
        if stop in self._calls:
            self._calls.remove(stop)

    def listen(self) -> None:
        """Catch the signals that end a process from now on, for a process of this software.

        SIGHUP stays ignored under `nohup`; SIGINT does not under a shell's `command &`.
        """
        for number in ENDING:
            if number != signal.SIGHUP or signal.getsignal(number) is not signal.SIG_IGN:
                signal.signal(number, self._on_signal)
                self._before[number] = signal.SIG_DFL
        signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDING)  # see `held`

    @contextmanager
    def listening(self) -> Iterator[None]:
        """Inside, catch Ctrl-C, for a call in a program of the user. Afterwards it raises KeyboardInterrupt;
        another handler, or a call from another thread, is left alone.
        """
        default = signal.getsignal(signal.SIGINT) is signal.default_int_handler
        if not default or threading.current_thread() is not threading.main_thread():
            yield
            return
        self._before[signal.SIGINT] = signal.default_int_handler
        signal.signal(signal.SIGINT, self._on_signal)
        try:
            yield
        finally:
            signal.signal(signal.SIGINT, signal.default_int_handler)
            self._before.clear()
            self.number, self.count, self._unseen = 0, 0, None

    def ignore(self) -> None:
        """Ignore further signals: for a process that ends anyway."""
        for number in ENDING:
            signal.signal(number, signal.SIG_IGN)

    def exit(self) -> NoReturn:
        """End this process at once, with the status of its signal, without waiting for other threads."""
        for file in (sys.stdout, sys.stderr):
            with suppress(OSError):  # full, or its reader or terminal is gone
                file.flush()
        os._exit(self.status)

    @contextmanager
    def held(self) -> Iterator[None]:
        """Inside, signals wait, in processes that are started here even for ever: these leave them to this
        process, unless they listen themselves. A process that is forked inside, and leaves the context as
        well, loses none: Python forgets in a new process the signals from before it was ready.
        """
        before = signal.pthread_sigmask(signal.SIG_BLOCK, ENDING)
        try:
            yield
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)

    def _on_signal(self, number: int, _frame: FrameType | None) -> None:
        now = time.monotonic()
        if self._unseen is not None and now > self._unseen + _HELD_UP:
            signal.signal(number, self._before[number])
            signal.raise_signal(number)
            return
        self.number = self.number or number
        self.count += 1
        self._unseen = self._unseen or now
        for stop in tuple(self._calls):
            stop()


STOP: Final = StopSignal()
