"""A run in this process, one tick at a time."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from deploy.run.local import LocalFleet
from deploy.run.operator import Operator
from deploy.telemetry.recording.reader import Said, Truths
from disknav.orders import Orders
from disknav.scenarios import Settings, Source, ready
from disknav.trajectory import Floats, Trajectory
from protocol.keys import checked_run
from protocol.messages import Truth
from protocol.process.signals import STOP


class Simulation:
    """World and robots of one lock-step run, which goes on when `step` is called.

    Iterating over it goes on to the verdict, and gives the positions (m, shape (p, 2)) after each tick.

    Attributes:
        orders: sends robots elsewhere between two steps; an order holds from the next tick on.
    """

    def __init__(
        self,
        scenario: Source,
        settings: Settings | None = None,
        *,
        seed: int | None = None,
        name: str = "local",
    ) -> None:
        """Arguments and errors are those of `disknav.run`."""
        self.scenario = ready(scenario, settings, seed)
        self._fleet = LocalFleet(self.scenario, checked_run(name))
        self._truths = [self._truth]
        self.orders = Orders(Operator(self._fleet.network.connect(), name))

    @property
    def tick(self) -> int:
        """How many ticks are over."""
        return self._fleet.world.world.tick

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self.tick * self.scenario.time.step

    @property
    def verdict(self) -> str:
        """How the run ended; empty while it goes on."""
        return self._fleet.world.world.verdict

    @property
    def positions(self) -> Floats:
        """Where all disks that are there are, m, shape (p, 2), in the order of ids."""
        return np.array(self._truths[-1].positions)

    @property
    def trajectory(self) -> Trajectory:
        """From tick 0 to now."""
        return Trajectory.of(self.scenario, Truths.of(map(Said.of, self._truths)))

    def step(self) -> bool:
        """Go on by one tick; False, and nothing happens, once the run has its verdict."""
        if self.verdict:
            return False
        self._fleet.step()
        if self._truth.tick > self._truths[-1].tick:
            self._truths.append(self._truth)
        return True

    def __iter__(self) -> Iterator[Floats]:
        """Positions after every tick that follows, up to the verdict."""
        while self.step():
            yield self.positions

    def finish(self) -> dict[str, Any]:
        """Go on to the verdict; the world's report. Ctrl-C ends the run as "interrupted"."""
        with STOP.listening():
            while not STOP.requested and self.step():
                pass
            return self._fleet.execute()

    @property
    def _truth(self) -> Truth:
        return self._fleet.world.world.truth
