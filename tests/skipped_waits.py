"""A clock for runs in which nobody outside is waited for: time that would be slept through is skipped.

World and robots give each other seconds of wall time where a network may have lost something. Within one
process nothing comes later by itself, so that whoever would sleep may as well be told that it has: waits
cost nothing, and what comes of them does not depend on how busy the machine is.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import SupportsIndex


@contextmanager
def skipped_waits() -> Iterator[None]:
    """Inside, in this thread, `time.sleep` returns at once and `time.monotonic` has moved on by as much."""
    monotonic, sleep, owner = time.monotonic, time.sleep, threading.get_ident()
    skipped = 0.0

    def now() -> float:
        return monotonic() + skipped if threading.get_ident() == owner else monotonic()

    def skip(seconds: float | SupportsIndex) -> None:
        nonlocal skipped
        if threading.get_ident() == owner:
            skipped += float(seconds)
        else:
            sleep(seconds)

    time.monotonic, time.sleep = now, skip
    try:
        yield
    finally:
        time.monotonic, time.sleep = monotonic, sleep
