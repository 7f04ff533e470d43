"""What a page or table shows: a view that another thread keeps up to date, and a way to steer the run."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any, Protocol

from deploy.monitor.view import snapshot as telling
from deploy.monitor.view.fleet import View
from protocol.requests.goals import GoalOrder, GoalReply
from protocol.requests.steering import Steer


class Source(Protocol):
    """Where a viewer gets its data; every method may be called from any thread."""

    def overview(self) -> dict[str, Any]:
        """`telling.overview`, now."""

    def snapshot(self, since: int = -1) -> dict[str, Any]:
        """`telling.snapshot`, now."""

    def steer(self, steer: Steer) -> None:
        """Ask for a pause, steps or a speed; takes effect soon, and shows in a later snapshot."""

    def order(self, robot: int, order: GoalOrder) -> Future[GoalReply]:
        """Send a robot elsewhere; what is accepted shows in a later snapshot."""

    def halt(self, halt: bool) -> Future[str]:
        """Have every robot stand at once, or release them; the text says why that failed, empty if not."""


class SharedView:
    """A view with a lock: one thread writes, others look. They never wait for each other's network."""

    def __init__(self, run: str, clock: Callable[[], float] = time.monotonic) -> None:
        self._view = View(run)
        self._lock = threading.Lock()
        self._clock = clock

    def overview(self) -> dict[str, Any]:
        """See `telling.overview`."""
        with self._lock:
            return telling.overview(self._view)

    def snapshot(self, since: int = -1) -> dict[str, Any]:
        """See `telling.snapshot`."""
        with self._lock:
            return telling.snapshot(self._view, self._clock(), since)

    def change(self, what: Callable[[View, float], None]) -> None:
        """Let `what` work on the view at the present time, while nobody looks."""
        with self._lock:
            what(self._view, self._clock())
