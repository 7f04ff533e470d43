"""Runs one node on one bus until the node is finished: the whole of a real process's main loop."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from types import FrameType
from typing import Final, NoReturn

from protocol.bus.bus import Bus, Node
from protocol.process.signals import heard_by

_TOGETHER: Final = 256  # events that are handled before the clock is looked at again
_SIGNALS = (signal.SIGTERM, signal.SIGINT)


class Stop(BaseException):
    """SIGTERM or SIGINT asked this process to end; `signal` says which."""

    def __init__(self, number: int) -> None:
        self.signal = signal.Signals(number)
        super().__init__(self.signal.name)


@contextmanager
def stop_on_signal() -> Iterator[None]:
    """Inside, SIGTERM and SIGINT raise `Stop` once; further ones wait for the clean-up. Main thread only."""
    before = {number: signal.signal(number, _stop) for number in _SIGNALS}
    try:
        yield
    finally:
        for number, handler in before.items():
            if handler is not _stop:  # nested: the outermost restores, and until then a stop is a stop
                signal.signal(number, handler)


def _stop(number: int, _frame: FrameType | None) -> NoReturn:
    for each in _SIGNALS:
        signal.signal(each, signal.SIG_IGN)
    raise Stop(number)


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Inside, SIGINT, SIGTERM and SIGHUP wait: for what must not be left half done, and does not take long.

    They are held back where Python handles them, which is in the main thread: to block them in one thread
    leaves them to others, of which a session has many.
    """
    held: list[int] = []
    try:
        with heard_by(lambda number, _: held.append(number)):
            yield
    finally:
        with ExitStack() as stack:  # each, also if the one before it ends what is done here
            for number in reversed(held):
                stack.callback(signal.raise_signal, number)


def drive(
    node: Node,
    bus: Bus,
    *,
    on_stop: Callable[[], None] | None = None,
    beat: Callable[[float], None] | None = None,
) -> None:
    """Feed `node` with the events of `bus` until it is finished; the bus is closed in any case.

    `on_stop` is called when a signal ends the loop, while the bus is still open: for last words. `beat` is
    told the time, s, whenever the loop comes round.

    Raises:
        Stop: SIGTERM or SIGINT arrived.
    """
    with stop_on_signal():
        try:
            follow(node, bus, beat)
        except Stop:
            if on_stop is not None:
                on_stop()
            raise
        finally:
            bus.close()


def follow(node: Node, bus: Bus, beat: Callable[[float], None] | None = None) -> None:
    """Feed `node` with the events of `bus` until it is finished, and no more.

    What has arrived comes before a deadline that is over: the node was late, not who spoke.
    """
    receive, handle = bus.receive, node.handle  # looked up once: this goes round for every message
    while not node.finished:
        event = receive(max(0.0, node.deadline - time.monotonic()))
        handled = 0
        while event is not None:
            handle(event)
            handled += 1
            if handled == _TOGETHER or node.finished:
                break
            event = receive(0.0)
        now = time.monotonic()
        if beat is not None:
            beat(now)
        if now >= node.deadline and not node.finished:
            node.wake(now)
