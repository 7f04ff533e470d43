"""How far a study is, and when it will be done, on standard error."""

from __future__ import annotations

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.progress import TimeRemainingColumn as TimeLeftColumn


class StudyProgress:
    """A bar over all runs, those known from before included; a context manager."""

    def __init__(self, name: str, total: int, done: int, quiet: bool) -> None:
        self._progress = Progress(
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
        self._task = self._progress.add_task("", total=total, completed=done)

    def __enter__(self) -> StudyProgress:
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()

    def advance(self, said: str) -> None:
        """One more run is done; `said` stands beside the bar."""
        self._progress.update(self._task, advance=1, description=said)
