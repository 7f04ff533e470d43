"""What a supervisor and its fork server say to each other: requests one way, news the other."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple


class Start(NamedTuple):
    """Request: fork a process that calls `entry` ("module:function") with `arguments`.

    `reports`: the function gets one more argument, a callable that sends text to the supervisor.
    """

    life: int  # names this one process, for ever
    name: str
    entry: str
    arguments: tuple[Any, ...]
    reports: bool
    log: Path | None  # where its output goes; the terminal unless given


class Signal(NamedTuple):
    """Request: send a signal. To a process that has ended, nothing is sent."""

    life: int
    number: int


class Started(NamedTuple):
    """News: the process exists."""

    life: int
    pid: int


class Report(NamedTuple):
    """News: the process says something."""

    life: int
    text: str


class Exited(NamedTuple):
    """News: the process is gone; the exit code is negative for a signal."""

    life: int
    code: int
    cpu_s: float
    max_rss_mb: float


Request = Start | Signal
News = Started | Report | Exited
