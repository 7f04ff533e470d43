"""The real fleet under the clock: rate, processor time, start-up and memory of real robots on real zenoh."""

from __future__ import annotations

import os
import time
from dataclasses import replace
from statistics import median
from typing import Literal, NamedTuple

import psutil

from deploy.library.load import load
from deploy.run.fleet import Fleet
from deploy.run.options import RunOptions
from protocol.messages import Clock
from protocol.scenario.model import Scenario

Filter = Literal["separating-lines", "none"]
Interest = Literal["near", "all"]
_TURNS = 1000  # runs one after another with the same processes: nobody counts ticks beyond the time asked for


class Measured(NamedTuple):
    """What a fleet did.

    `cpu_ms` is the processor time of all processes per tick, `start` the time from the call to the first
    tick (s), `private_mb` what a robot shares with nobody (the median of all processes, most of which are).
    """

    ticks_per_second: float
    cpu_ms: float
    start: float
    private_mb: float


def scenario(robots: int, safety: Filter = "separating-lines", interest: Interest | None = None) -> Scenario:
    """A swap up to 8 robots, which is over in about 250 ticks, else a random instance; who hears whom is as
    by default unless `interest` says so."""
    loaded = load(f"swap-{robots}" if robots <= 8 else f"random-{robots}")
    network = replace(loaded.network, interest=interest)
    return replace(loaded, control=replace(loaded.control, filter=safety), network=network)


def measure(
    robots: int,
    seconds: float = 3.0,
    safety: Filter = "separating-lines",
    restarts: int = 0,
    interest: Interest | None = None,
) -> Measured:
    """Run a routed fleet in lock-step for about `seconds`; with `restarts` its world keeps a journal."""
    repeated = [scenario(robots, safety, interest)] * _TURNS
    watch = _Watch(seconds)
    with Fleet(repeated, RunOptions("routed", "lockstep", restarts=restarts), watch=watch) as fleet:
        fleet.execute()
    return watch.measured()


class _Watch:
    """Follows the clock; ends the run, as Ctrl-C would, when there is enough."""

    def __init__(self, seconds: float) -> None:
        self._processes: list[psutil.Process] = []
        self._seconds = seconds
        self._began = time.perf_counter()
        self._start = self._cpu = self._elapsed = self._private = 0.0
        self._ticks = 0
        self._over = False
        self._last: tuple[float, Clock] | None = None

    def __call__(self, clock: Clock) -> None:
        now = time.perf_counter()
        if self._over or clock.tick == 0:
            self._last = None
            return
        if not self._start:
            self._start = now - self._began
            self._processes = psutil.Process(os.getpid()).children(recursive=True)
            self._cpu = self._used()
            now = time.perf_counter()
        elif self._last is not None and self._last[1].run_number == clock.run_number:
            self._elapsed += now - self._last[0]
            self._ticks += clock.tick - self._last[1].tick
        self._last = now, clock
        if self._elapsed >= self._seconds:
            self._over = True
            self._cpu = self._used() - self._cpu
            self._private = median(map(_private, self._processes))
            raise KeyboardInterrupt

    def measured(self) -> Measured:
        """The figures, once the run is over."""
        return Measured(
            self._ticks / self._elapsed, 1000.0 * self._cpu / self._ticks, self._start, self._private
        )

    def _used(self) -> float:
        """Processor time of all processes of the fleet so far, s."""
        times = [process.cpu_times() for process in self._processes]
        return sum(each.user + each.system for each in times)


def _private(process: psutil.Process) -> float:
    """Memory that a process shares with nobody, MB."""
    return float(process.memory_full_info().uss) / 2**20
