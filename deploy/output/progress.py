"""What a command shows on standard error while it works: a bar, and how far a run is."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import (
    BarColumn,
    Progress,
    SpinnerColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from protocol.messages import Clock
from protocol.process.signals import STOP
from protocol.scenario.model import Scenario

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


class RunProgress(Progress):
    """Shows simulated time and clearance while a run goes on; a context manager."""

    def __init__(self, scenario: Scenario, quiet: bool) -> None:
        console = Console(stderr=True)
        super().__init__(
            SpinnerColumn(),
            TextColumn("{task.description}"),
            BarColumn(bar_width=24),
            TextColumn("{task.fields[figures]}"),
            TimeElapsedColumn(),
            console=console,
            refresh_per_second=5,
            transient=True,
            disable=quiet or not console.is_terminal,  # in a file it would be an empty line
        )
        self._task = self.add_task(scenario.name, total=scenario.time.limit, figures="starting")

    def watch(self, clock: Clock) -> None:
        """Take over news from the world."""
        figures = f"t = {clock.time:5.2f} s   clearance {1000 * clock.clearance:6.2f} mm"
        self.update(self._task, completed=clock.time, figures=figures)
