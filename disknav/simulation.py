"""A run in this process, one tick at a time."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, SupportsFloat

import numpy as np

from agents.shell.node import RobotNode
from deploy.run.local import LocalFleet
from deploy.run.operator import Operator
from deploy.telemetry.recording.reader import Said, Truths
from disknav.orders import Orders, finite
from disknav.scenarios import Settings, Source, ready
from disknav.trajectory import Floats, Trajectory
from protocol.keys import checked_run
from protocol.messages import Truth
from protocol.process.signals import STOP


class Simulation:
    """World and robots of one lock-step run in this process; each call of `step` is one tick.

    Iteration runs to the verdict and yields the positions (m, shape (p, 2)) after each tick.

    Attributes:
        orders: goals and obstacles between two steps; an order takes effect at the next tick.
    """

    def __init__(
        self,
        scenario: Source,
        settings: Settings | None = None,
        *,
        seed: int | None = None,
        name: str = "local",
    ) -> None:
        """Arguments and errors as of `disknav.run`."""
        self.scenario = ready(scenario, settings, seed)
        self._fleet = LocalFleet(self.scenario, checked_run(name))
        self._truths = [self._truth]
        self.orders = Orders(Operator(self._fleet.network.connect(), name))

    @property
    def tick(self) -> int:
        """Number of completed ticks."""
        return self._fleet.world.world.tick

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self.tick * self.scenario.time.step

    @property
    def verdict(self) -> str:
        """Verdict of the run; empty while it continues."""
        return self._fleet.world.world.verdict

    @property
    def clearance(self) -> float:
        """Smallest gap of the fleet during the newest tick, m, over continuous time; negative is overlap."""
        return self._truths[-1].clearance

    @property
    def positions(self) -> Floats:
        """Positions of all present disks, m, shape (p, 2), in the order of ids."""
        return np.array(self._truths[-1].positions)

    @property
    def trajectory(self) -> Trajectory:
        """Trajectory from tick 0 to the current tick."""
        return Trajectory.of(self.scenario, Truths.of(map(Said.of, self._truths)))

    def join(self) -> None:
        """Let all robots join the run; otherwise the first `step` does."""
        self._fleet.network.run(lambda: STOP.requested or all(each.core for each in self._nodes().values()))

    def tell(self, wishes: Mapping[int, Iterable[SupportsFloat]]) -> None:
        """Set desired velocities from the next tick on, m/s by id, if the scenario has `control.law =
        "external"`.

        Like `orders.wish`, but without a message. Robots that have not joined, or whose processes are down,
        are skipped.

        Raises:
            UsageError: a velocity is not two finite numbers.
        """
        nodes = self._nodes()
        for robot, wish in wishes.items():
            if robot in nodes and (core := nodes[robot].core) is not None:
                core.tell(finite(wish))

    def _nodes(self) -> dict[int, RobotNode]:
        """Nodes of all robots whose processes run, by id."""
        nodes = {robot: bus.node for robot, bus in self._fleet.robots.items()}
        return {robot: node for robot, node in nodes.items() if isinstance(node, RobotNode)}

    def step(self) -> bool:
        """Advance one tick; return False without effect once the run has a verdict."""
        if self.verdict:
            return False
        self._fleet.step()
        if self._truth.tick > self._truths[-1].tick:
            self._truths.append(self._truth)
        return True

    def __iter__(self) -> Iterator[Floats]:
        """Positions after each further tick, up to the verdict."""
        while self.step():
            yield self.positions

    def finish(self) -> dict[str, Any]:
        """Advance to the verdict and return the world's report. Ctrl-C ends the run as "interrupted"."""
        with STOP.listening():
            while not STOP.requested and self.step():
                pass
            return self._fleet.execute()

    @property
    def _truth(self) -> Truth:
        return self._fleet.world.world.truth
