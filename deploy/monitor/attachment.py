"""Watching from outside: a zenoh session of its own, on a thread of its own."""

from __future__ import annotations

import threading
import time

from deploy.monitor.watcher import Watcher
from protocol.bus import Bus
from protocol.bus_zenoh import ZenohBus
from protocol.connection import Connection
from protocol.keys import checked_run

_LONGEST_WAIT = 0.05  # s; how soon `close` is noticed


class Attachment(Watcher):
    """A watcher that drives itself until `close`."""

    def __init__(self, bus: Bus, run: str, *, speed: float | None = None) -> None:
        super().__init__(bus, run, speed=speed)
        self._thread = threading.Thread(target=self._loop, name=f"monitor of {run}", daemon=True)
        self._thread.start()

    def _loop(self) -> None:
        try:
            while not self.finished:
                now = time.monotonic()
                if now >= self.deadline:
                    self.wake(now)
                event = self._bus.receive(min(_LONGEST_WAIT, max(0.0, self.deadline - now)))
                if event is not None:
                    self.handle(event)
        finally:
            self._bus.close()

    def close(self) -> None:
        """Stop watching and disconnect; may be called twice."""
        self.finished = True
        self._thread.join()


def attach(connection: Connection, run: str, *, speed: float | None = None) -> Attachment:
    """Watch `run` over a session of its own. The run need not be there yet.

    The fleet does not notice: all that is subscribed to is dropped rather than waited for when this
    process cannot keep up.

    Raises:
        BusError: nobody listens where `connection` leads.
        KeyGrammarError: the run name cannot be one.
    """
    checked_run(run)
    return Attachment(ZenohBus(connection), run, speed=speed)
