"""A progress bar on standard error for whatever turns out to take more than two seconds."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from protocol.process.signals import STOP

_PATIENCE = 2.0  # s without a bar


@contextmanager
def bar(description: str, *, silent: bool = False) -> Iterator[Callable[[float], None]]:
    """Inside, tell the function that is given how much is done, from 0 to 1; nothing is shown if `silent`.

    It raises Stopped if a signal asks this process to end.
    """
    columns = TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn()
    progress = Progress(*columns, console=Console(stderr=True), transient=True, disable=silent)
    task = progress.add_task(description, total=1.0)
    began = time.monotonic()

    def tell(done: float) -> None:
        STOP.check()
        progress.update(task, completed=done)
        if time.monotonic() > began + _PATIENCE:
            progress.start()

    try:
        yield tell
    finally:
        progress.stop()
