"""The real fleet under the clock: rate, processor time, start-up and memory of real robots on real zenoh."""

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
from protocol.scenario.model import Journey, Order, Scenario

Filter = Literal["separating-lines", "none"]
Interest = Literal["near", "all"]


class Measured(NamedTuple):
    """What a fleet did.

    `cpu_ms` is the processor time of all processes per tick, `start` the time from the call to the first
    tick (s), `private_mb` its unshared memory (the median of all processes, most of which are).
    """

    ticks_per_second: float
    cpu_ms: float
    start: float
    private_mb: float


def scenario(robots: int, safety: Filter = "separating-lines", interest: Interest | None = None) -> Scenario:
    """Robots that go to and fro without end: those of a swap up to 8, else of a random instance; interest is
    the default unless given."""
    loaded = load(f"swap-{robots}" if robots <= 8 else f"random-{robots}")
    network = replace(loaded.network, interest=interest)
    journeys = (Journey(each.id, (each.goal, each.start), patrol=True) for each in loaded.robots)
    return replace(
        loaded,
        control=replace(loaded.control, filter=safety),
        network=network,
        time=replace(loaded.time, endless=True),
        orders=tuple(Order(0.0, goal=journey) for journey in journeys),
    )


def measure(
    robots: int, seconds: float, safety: Filter = "separating-lines", interest: Interest | None = None
) -> Measured:
    """Run a routed fleet in lock-step for about `seconds`."""
    watch = _Watch(seconds)
    with Fleet(scenario(robots, safety, interest), RunOptions("routed", "lockstep"), watch=watch) as fleet:
        fleet.execute(lambda: watch.over)
    return watch.measured()


class _Watch:
    """Follows the clock, until there is enough."""

    def __init__(self, seconds: float) -> None:
        self._processes: list[psutil.Process] = []
        self._seconds = seconds
        self._began = time.perf_counter()
        self._start = self._cpu = self._elapsed = self._private = 0.0
        self._ticks = 0
        self.over = False
        self._last: tuple[float, Clock] | None = None

    def __call__(self, clock: Clock) -> None:
        now = time.perf_counter()
        if self.over or clock.tick == 0:
            self._last = None
            return
        if not self._start:
            self._start = now - self._began
            self._processes = psutil.Process(os.getpid()).children(recursive=True)
            self._cpu = self._used()
            now = time.perf_counter()
        elif self._last is not None:
            self._elapsed += now - self._last[0]
            self._ticks += clock.tick - self._last[1].tick
        self._last = now, clock
        if self._elapsed >= self._seconds:
            self.over = True
            self._cpu = self._used() - self._cpu
            self._private = median(map(_private, self._processes))

    def measured(self) -> Measured:
        return Measured(
            self._ticks / self._elapsed, 1000.0 * self._cpu / self._ticks, self._start, self._private
        )

    def _used(self) -> float:
        """Processor time of all processes of the fleet so far, s."""
        times = [process.cpu_times() for process in self._processes]
        return sum(each.user + each.system for each in times)


def _private(process: psutil.Process) -> float:
    return float(process.memory_full_info().uss) / 2**20
