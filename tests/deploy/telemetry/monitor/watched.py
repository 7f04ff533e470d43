"""Fleets in this process for tests of monitors."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from math import cos, pi, sin

from deploy.run.local import LocalFleet
from deploy.telemetry.monitor.watcher import Watcher
from protocol.bus.local import LocalNetwork
from protocol.operations import Steer
from protocol.scenario.model import Control, ProcessFault, RobotSpec, Scenario, Time
from tests.until import PATIENCE


def ring(robots: int = 4, limit: float = 60.0, kill: int | None = None, at: float = 0.5) -> Scenario:
    """Robots on a circle, each to the place after the next; `kill` one of them `at` some time."""
    places = [(0.2 * cos(2 * pi * i / robots), 0.2 * sin(2 * pi * i / robots)) for i in range(robots)]
    specs = tuple(RobotSpec(i + 1, 0.03, places[i], places[(i + 2) % robots]) for i in range(robots))
    faults = () if kill is None else (ProcessFault(kill, at, "kill"),)
    return Scenario(specs, name="ring", time=Time(limit=limit), control=Control(k=40.0), process=faults)


@contextmanager
def running(fleet: LocalFleet) -> Iterator[None]:
    """A fleet on a thread of its own, stopped at the end whether it has finished or not."""
    stop = threading.Event()
    thread = threading.Thread(
        target=fleet.network.run, args=(lambda: stop.is_set() or fleet.world.finished,), daemon=True
    )
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join(PATIENCE)


def watch_local(network: LocalNetwork, run: str, *, speed: float | None = None) -> Watcher:
    """Watch a run that goes on in this process; the network's own thread drives the watcher."""
    bus = network.connect()
    watcher = bus.node = Watcher(bus, run)
    if speed is not None:
        watcher.steer(Steer(speed=speed))
    return watcher
