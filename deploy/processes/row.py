"""A row of the process table while the fleet runs: its latest process, and what it cost so far."""

from __future__ import annotations

import signal
from dataclasses import dataclass, field
from typing import NamedTuple

import psutil

from deploy.processes.backoff import Backoff
from deploy.processes.fork_messages import MAX_NEWS
from deploy.processes.table import Process

_MOST = 1000  # reports that wait to be asked for
_UNHEARD = 2 * MAX_NEWS  # characters of them


class Exit(NamedTuple):
    """A process ended.

    expected: it was told to, or finished with status 0; again: it is started anew by itself.
    """

    process: Process
    code: int
    expected: bool
    again: bool = False
    why: str = ""  # where the code does not say it

    def __str__(self) -> str:
        if self.why:
            return f"{self.process.name}: {self.why}"
        if self.code >= 0:
            return f"{self.process.name}: exit status {self.code}"
        known = {each.value: each.name for each in signal.Signals}
        return f"{self.process.name}: killed by {known.get(-self.code, f'signal {-self.code}')}"


class Usage(NamedTuple):
    """What one row of the table cost, over all its lives so far."""

    name: str
    pid: int  # of the latest life
    exit_code: int | None  # of the latest life; None while it runs
    restarts: int
    cpu_s: float
    max_rss_mb: float


@dataclass
class Life:
    """One row with its latest process."""

    process: Process
    number: int
    pid: int = 0
    exit_code: int | None = None
    up: bool = False  # whether it, or one before it, has done anything that it is for
    told_to_end: bool = False
    again: bool = False  # start it again as soon as it has ended
    began: float = 0.0  # s, monotonic: when the latest was asked for
    due: float | None = None  # s, monotonic: when the next is to be started; none waits otherwise
    backoff: Backoff = field(default_factory=Backoff)
    restarts: int = 0
    failures: int = 0
    report: str | None = None  # the first of the latest process
    unheard: list[str] = field(default_factory=list)  # all reports that nobody has asked for
    cpu_s: float = 0.0  # of ended processes
    max_rss_mb: float = 0.0

    def hear(self, text: str) -> None:
        """Take a report, if its row makes any. Of what nobody asks for the newest is kept: a host that was
        taken over may never stop."""
        if not self.process.reports:
            return
        self.up = True
        self.report = self.report or text
        self.unheard.append(text)
        while len(self.unheard) > _MOST or sum(map(len, self.unheard)) > _UNHEARD:
            del self.unheard[0]

    @property
    def over(self) -> bool:
        """Whether its process has ended, and none follows by itself."""
        return self.exit_code is not None and self.due is None

    def usage(self) -> Usage:
        """What this row cost so far; of a running process, as the system says now."""
        cpu, rss = self.cpu_s, self.max_rss_mb
        if self.exit_code is None and self.pid:
            try:
                now = psutil.Process(self.pid)
                times = now.cpu_times()
                cpu, rss = cpu + times.user + times.system, max(rss, now.memory_info().rss / 2**20)
            except psutil.Error:  # ended since the last poll, which will say so
                pass
        return Usage(self.process.name, self.pid, self.exit_code, self.restarts, cpu, rss)
