"""What a page or table shows: a view that another thread keeps up to date."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

from deploy.telemetry.monitor.view import snapshot
from deploy.telemetry.monitor.view.fleet import View


class Source:
    """A view with a lock: one thread writes, others look. They never wait for each other's network.

    Every method may be called from any thread.
    """

    def __init__(self, run: str, clock: Callable[[], float] = time.monotonic) -> None:
        self._view = View(run)
        self._lock = threading.Lock()
        self._clock = clock

    def overview(self) -> dict[str, Any]:
        """What does not change, and the past; see `deploy.telemetry.monitor.view.snapshot`."""
        with self._lock:
            return snapshot.overview(self._view)

    def snapshot(self, since: int = -1) -> dict[str, Any]:
        """The present, and what happened after tick `since`."""
        with self._lock:
            return snapshot.snapshot(self._view, self._clock(), since)

    def change(self, what: Callable[[View, float], None]) -> None:
        """Let `what` work on the view at the present time, while nobody looks."""
        with self._lock:
            what(self._view, self._clock())
