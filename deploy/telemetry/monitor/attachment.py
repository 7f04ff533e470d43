"""Watching from outside: a zenoh session of its own, on a thread of its own."""

from __future__ import annotations

import threading
import time
from math import inf
from typing import TYPE_CHECKING

from deploy.telemetry.monitor.admin_space import ROUTERS, router
from deploy.telemetry.monitor.watcher import Watcher
from protocol.bus.bus import Bus
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from protocol.errors import BusError
from protocol.keys import checked_run

if TYPE_CHECKING:
    from deploy.telemetry.monitor.foxglove import FoxgloveServer

_LONGEST_WAIT = 0.05  # s; how soon `close` is noticed
_ADMIN_PERIOD, _ADMIN_TIMEOUT = 2.0, 0.1  # s


class Attachment(Watcher):
    """A watcher that drives itself until `close`."""

    def __init__(self, bus: Bus, run: str, *, listener: FoxgloveServer | None = None) -> None:
        super().__init__(bus, run, listener=listener)
        self._look_at = self.deadline
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
                if now >= self._look_at:
                    self._look_at_network(now)
        finally:
            self._bus.close()

    def _look_at_network(self, now: float) -> None:
        """See who is connected, if the admin space is on; where it is off, asking once was enough."""
        try:
            found = router(self._bus.ask(ROUTERS, b"", _ADMIN_TIMEOUT)[0])
        except BusError:
            found = None
        self._look_at = now + _ADMIN_PERIOD if found is not None else inf
        self.change(lambda view, _: setattr(view, "router", found))

    def close(self) -> None:
        """Stop watching and disconnect; may be called twice."""
        self.finished = True
        self._thread.join()


def attach(connection: Connection, run: str, *, listener: FoxgloveServer | None = None) -> Attachment:
    """Watch `run` over a session of its own. The run need not be there yet.

    The fleet does not notice: all that is subscribed to is dropped rather than waited for when this
    process cannot keep up.

    Raises:
        BusError: nobody listens where `connection` leads.
        KeyGrammarError: the run name cannot be one.
    """
    checked_run(run)
    return Attachment(ZenohBus(connection), run, listener=listener)
