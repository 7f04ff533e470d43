"""One line that says how far a run is, on standard error, a few times a second."""

from __future__ import annotations

from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from protocol.messages import Clock
from protocol.scenario.model import Scenario


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
