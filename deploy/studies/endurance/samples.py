"""What processes hold on to, sampled over time: memory, file handles, threads."""

from __future__ import annotations

import time
from array import array
from collections.abc import Mapping
from dataclasses import dataclass, field

import psutil

QUANTITIES = ("anonymous_mb", "private_mb", "resident_mb", "handles", "threads")


def _series() -> dict[str, array[float]]:
    return {name: array("d") for name in ("time", "pid", *QUANTITIES)}


@dataclass
class Samples:
    """Series by process name: s since the beginning, process id, MB (2^20 bytes), counts.

    anonymous_mb: resident memory that no file backs, which is what a process would leak. Whether a page that
    it has from the fork server is shared or was copied since does not matter.
    private_mb: memory that it shares with nobody; grows when such a page is copied, too.
    """

    period: float  # s between samples, at least
    of: dict[str, dict[str, array[float]]] = field(default_factory=dict)
    rest: float = 49.0  # times what a sample takes: the fleet shall not notice that it is looked at
    _began: float = field(default_factory=time.monotonic)
    _due: float = 0.0
    _known: dict[int, psutil.Process] = field(default_factory=dict)

    def take(self, pids: Mapping[str, int]) -> None:
        """Sample every process, if a sample is due. One that has just ended is passed over."""
        now = time.monotonic()
        if now < self._due:
            return
        for name, pid in pids.items():
            try:
                if pid not in self._known:
                    self._forget(pids)
                    self._known[pid] = psutil.Process(pid)
                self._sample(name, self._known[pid], now)
            except psutil.Error:
                continue
        done = time.monotonic()
        self._due = max(now + self.period, done + self.rest * (done - now))

    def _forget(self, pids: Mapping[str, int]) -> None:
        """Those that have ended."""
        for pid in self._known.keys() - set(pids.values()):
            del self._known[pid]

    def _sample(self, name: str, process: psutil.Process, now: float) -> None:
        memory = process.memory_full_info()
        backed = getattr(memory, "shared", None)  # as Linux knows it
        anonymous = memory.uss if backed is None else memory.rss - backed
        sizes = (each / 2**20 for each in (anonymous, memory.uss, memory.rss))
        values = (*sizes, process.num_fds(), process.num_threads())
        series = self.of.setdefault(name, _series())
        series["time"].append(now - self._began)
        series["pid"].append(process.pid)
        for quantity, value in zip(QUANTITIES, values, strict=True):
            series[quantity].append(value)
