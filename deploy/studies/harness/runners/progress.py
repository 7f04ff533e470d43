"""How far a study is, and when it will be done, on standard error."""

from __future__ import annotations

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.progress import TimeRemainingColumn as TimeLeftColumn


class StudyProgress(Progress):
    """A bar over all runs, those known from before included; a context manager."""

    def __init__(self, name: str, total: int, done: int, quiet: bool) -> None:
        super().__init__(
            TextColumn(name),
            BarColumn(bar_width=24),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            TextColumn("left"),
            TimeLeftColumn(),
            TextColumn("{task.description}"),
            console=Console(stderr=True),
            refresh_per_second=4,
            transient=True,
            disable=quiet,
        )
        self._task = self.add_task("", total=total, completed=done)

    def count(self, said: str) -> None:
        """One more run is done; `said` stands beside the bar."""
        self.update(self._task, advance=1, description=said)
