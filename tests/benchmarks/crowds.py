"""Robots that never rest: rate, commands missed, processor time, and contacts, by number of robots.

All goals are random and renewed for ever, at the paper's density. In real time the world waits for no robot:
what a robot does not command in time is missed. `us` is processor time of all processes, µs per robot and
tick, measured after the first two seconds; `kB` is what the fleet adds to the memory of all processes, per
robot, a share of the world's included.

    python -m tests.benchmarks.crowds --robots 32 64 128 200 --rate 10 --seconds 60
    chrt --rr 1 python -m tests.benchmarks.crowds --robots 200
    python -m tests.benchmarks.crowds --robots 100 1000 --rate 10 --transport local --mode lockstep
    python -m tests.benchmarks.crowds --robots 100 --fleets 10 --transport local --mode lockstep

The last has ten fleets of 100 in one process, which take turns and know nothing of each other: beside one
fleet of 1000, which fills the processor's caches as they do, it shows what a robot costs because its fleet is
large.
"""

import argparse
import gc
import os
import time
from collections.abc import Iterable, Mapping
from contextlib import ExitStack
from dataclasses import replace
from math import inf
from typing import Any, NamedTuple

import psutil

from deploy.library.instances import random_instance, random_starts
from deploy.library.load import resolved
from deploy.run.fleet import Fleet
from deploy.run.local import LocalFleet
from deploy.run.options import RunOptions, fresh_run_name
from protocol.bus.local import LocalNetwork
from protocol.messages import Clock
from protocol.scenario.model import Journey, Order, Position, Scenario
from protocol.scenario.network import Network

_LEGS = 6  # goals of each robot, which it goes to in turn for ever
_WARM = 2.0  # s of simulated time before processor time is counted


def restless(robots: int, rate: float = 20.0, seconds: float = 1e4, network: Network = Network()) -> Scenario:
    """Random robots under way between random goals; no two goals of one leg are too close."""
    instance = random_instance(robots, 0)
    radii, room = [spec.radius for spec in instance.robots], instance.workspace.disk_radius
    legs = [random_starts(radii, room, 0, 10 + leg) for leg in range(_LEGS)]
    clock = replace(instance.time, step=1.0 / rate, limit=seconds)
    orders = patrols({spec.id: [leg[index] for leg in legs] for index, spec in enumerate(instance.robots)})
    return resolved(replace(instance, time=clock, orders=orders, network=network))


def patrols(places: Mapping[int, Iterable[Position]]) -> tuple[Order, ...]:
    """Of each robot between its places, for ever."""
    return tuple(Order(0.0, goal=Journey(robot, tuple(at), patrol=True)) for robot, at in places.items())


class Measured(NamedTuple):
    """What a fleet did; rate and processor time of all processes are those after it was warm."""

    ticks: int
    ticks_per_second: float
    cpu_ms: float  # per tick
    memory: float  # kB per robot
    start: float  # s, until the first tick
    seconds: float  # that it took from there on
    missed: float  # share of all commands
    clearance: float  # m, smallest gap; negative is contact


class _Meter:
    """Follows the clock for processor time, for so many seconds, or until the run is nearly over."""

    def __init__(self, scenario: Scenario, seconds: float) -> None:
        self._warm, self._end = scenario.ticks(_WARM), 0.95 * scenario.ticks(scenario.time.limit)
        self._robots, self._seconds, self._empty = len(scenario.robots), seconds, _memory()
        self._began = time.perf_counter()
        self._tick, self._since, self._cpu = 0, 0.0, 0.0  # when it was warm
        self.start = self.opened = self.ticks_per_second = self.cpu_ms = self.memory = 0.0

    def __call__(self, clock: Clock) -> None:
        now = time.perf_counter()
        if clock.founded and not self.start:
            self.opened, self.start = now, now - self._began
        if clock.tick >= self._warm and not self._tick:
            self._tick, self._since, self._cpu = clock.tick, now, _processor_time()
        elif self._tick and not self.over and (now >= self._since + self._seconds or clock.tick >= self._end):
            ticks = clock.tick - self._tick
            self.ticks_per_second = ticks / (now - self._since)
            self.cpu_ms = 1e3 * (_processor_time() - self._cpu) / ticks
            self.memory = (_memory() - self._empty) / 1000.0 / self._robots

    @property
    def over(self) -> bool:
        return self.ticks_per_second > 0.0


def _processor_time() -> float:
    """Of this process and all that it started, s."""
    return sum(sum(each.cpu_times()[:2]) for each in _processes())


def _memory() -> float:
    """Unshared memory of the same processes, without garbage of this one, bytes."""
    gc.collect()
    return sum(float(each.memory_full_info().uss) for each in _processes())


def _processes() -> list[psutil.Process]:
    own = psutil.Process(os.getpid())
    return [own, *own.children(recursive=True)]


def measure(scenario: Scenario, options: RunOptions, seconds: float = inf, fleets: int = 1) -> Measured:
    """One run, which ends once it was measured for so long (s), with other `fleets` like it in this
    process."""
    meter = _Meter(scenario, seconds)
    if options.transport == "local":
        network, lockstep = LocalNetwork(), options.mode == "lockstep"
        with ExitStack() as others:
            for other in range(1, fleets):
                others.enter_context(
                    LocalFleet(scenario, f"other-{other}", lockstep=lockstep, network=network)
                )
            fleet = LocalFleet(scenario, lockstep=lockstep, network=network, watch=meter)
            report: dict[str, Any] = others.enter_context(fleet).execute()
    else:
        with Fleet(scenario, options, watch=meter) as processes:
            report = processes.execute(lambda: meter.over and seconds < inf)
    return Measured(
        report["ticks"],
        meter.ticks_per_second,
        meter.cpu_ms,
        meter.memory,
        meter.start,
        time.perf_counter() - meter.opened,
        report["missed_commands"] / len(scenario.robots) / max(1, report["ticks"]),
        report["min_clearance"],
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--robots", type=int, nargs="+", default=[32, 64, 128, 200])
    parser.add_argument("--rate", type=float, default=10.0, help="ticks per simulated second")
    parser.add_argument("--seconds", type=float, default=60.0, help="of simulated time")
    parser.add_argument("--transport", choices=("routed", "mesh", "local"), default="routed")
    parser.add_argument("--mode", choices=("realtime", "lockstep"), default="realtime")
    parser.add_argument("--fleets", type=int, default=1, help="at once, with --transport local")
    chosen = parser.parse_args()
    options = RunOptions(chosen.transport, chosen.mode)
    print("robots  ticks  missed %       us     kB  start s  took s  clearance mm")
    for robots in chosen.robots:
        scenario = restless(robots, chosen.rate, chosen.seconds)
        row = measure(scenario, replace(options, run=fresh_run_name()), fleets=chosen.fleets)
        us, memory = 1e3 * row.cpu_ms / robots / chosen.fleets, row.memory / chosen.fleets
        print(
            f"{robots:6d}  {row.ticks:5d}  {100 * row.missed:8.3f}  {us:7.0f}"
            f"  {memory:5.0f}  {row.start:7.2f}  {row.seconds:6.1f}  {1000 * row.clearance:12.3f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
