"""A fleet that is watched while it endures, and what is done to it."""

from __future__ import annotations

import os
import signal
import time
from collections import Counter
from collections.abc import Sequence
from contextlib import ExitStack

from deploy.processes.table import ROUTER, WORLD
from deploy.run.fleet import Fleet
from deploy.run.topology import Routed, Topology
from deploy.studies.endurance.cables import Cables
from deploy.studies.endurance.disturbances import CUT, Blow, Disturbances
from deploy.studies.endurance.recovery import Recovery
from deploy.studies.endurance.trial import Trial
from protocol.bus.events import Sample
from protocol.bus.zenoh import ZenohBus
from protocol.errors import MessageError
from protocol.keys import world_key
from protocol.messages import Clock, Truth
from protocol.scenario.model import Scenario
from protocol.wire.codec import decode

LAUNCHER = "launcher"
CABLES = "cables"


class Observation:
    """Watches a fleet, and does to it what is due.

    Attributes:
        blows: how many of each kind there were.
    """

    def __init__(self, trial: Trial, scenarios: Sequence[Scenario], stack: ExitStack) -> None:
        self.recovery = Recovery()
        self.blows: Counter[str] = Counter()
        self._trial, self._scenarios, self._stack = trial, scenarios, stack
        self._disturbances = Disturbances(trial.kill_every, trial.cut_every)
        self._cables: Cables | None = None
        self._bus: ZenohBus | None = None
        self._fleet: Fleet | None = None
        self._began: float | None = None  # s, monotonic: with the first tick

    def lead(self, topology: Topology) -> Topology:
        """Every robot at a cable, if any is to be pulled."""
        if not self._trial.cut_every or not isinstance(topology, Routed):
            return topology
        cables = Cables(topology, self._scenarios[0].ids, self._trial.options.run)
        self._cables = self._stack.enter_context(cables)
        return cables.topology()

    def attach(self, fleet: Fleet) -> None:
        """Look at where robots are, if that is needed."""
        self._fleet = fleet
        if self._trial.disturbed:
            self._bus = ZenohBus(fleet.topology.observer())
            self._stack.callback(self._bus.close)
            self._bus.subscribe(world_key(self._trial.options.run, "truth"))

    def watch(self, clock: Clock) -> None:
        """What the world's clock says."""
        if self._began is None or (clock.tick == 0 and clock.run_number == 0):
            self._began = time.monotonic()
        robots = self._scenarios[min(clock.run_number, len(self._scenarios) - 1)].robots
        self.recovery.goals = {robot.id: robot.goal for robot in robots}

    def pids(self) -> dict[str, int]:
        """Of all processes that take part."""
        assert self._fleet is not None
        cables = {} if self._cables is None else {CABLES: self._cables.pid}
        return {**self._fleet.pids(), **cables, LAUNCHER: os.getpid()}

    def follow(self) -> float:
        """Hear where robots are, do what is due; returns the s since the first tick."""
        now = time.monotonic()
        while self._bus is not None and (event := self._bus.receive(0.0)) is not None:
            if isinstance(event, Sample):
                self._see(event, now)
        if self._began is None:
            return 0.0
        elapsed = now - self._began
        if elapsed < 60.0 * self._trial.minutes:
            blow = self._disturbances.due(elapsed, self.recovery.under_way)
            if blow is not None:
                self._strike(blow, now)
        return elapsed

    def _see(self, sample: Sample, now: float) -> None:
        try:
            truth = decode(sample.key, sample.payload)
        except MessageError:
            return
        if isinstance(truth, Truth):
            self.recovery.see(truth, now)

    def _strike(self, blow: Blow, now: float) -> None:
        if blow.cut is not None and self._cables is not None:
            self._cables.pull(blow.cut, CUT)
            self.recovery.hit("link cut", [blow.cut], now + CUT)
            self.blows["link cut"] += 1
        elif blow.kill is not None and self._fleet is not None:
            self._fleet.signal(blow.kill, signal.SIGKILL)
            vital = blow.kill in (ROUTER, WORLD)
            what = f"{blow.kill if vital else 'robot'} killed"
            robots = self.recovery.under_way if vital else [int(blow.kill.rpartition("-")[-1])]
            self.recovery.hit(what, robots, now)
            self.blows[what] += 1
