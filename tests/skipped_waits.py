"""A clock for runs within one process: time that a process would sleep through is skipped.

World and robots give each other seconds of wall time where a network may have lost something. Within one
process nothing arrives later by itself, so that a wait may as well be over at once: it costs nothing, and its
outcome does not depend on the load of the machine.
"""

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import SupportsIndex


@contextmanager
def skipped_waits() -> Iterator[None]:
    """Inside, in this thread, `time.sleep` returns at once, and `time.monotonic` has moved on by as much.

    Besides that it moves on by the processor time of the thread, for a run has the same outcome on a machine
    that is busy with others.
    """
    monotonic, sleep, owner = time.monotonic, time.sleep, threading.get_ident()
    skipped = monotonic() - time.thread_time()

    def now() -> float:
        return time.thread_time() + skipped if threading.get_ident() == owner else monotonic()

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
