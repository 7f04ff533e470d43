"""A run in this process, one tick at a time; or to its verdict, here or as a fleet of processes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, SupportsFloat

import numpy as np

from agents.shell.node import RobotNode
from deploy.output import check_target
from deploy.run.execute import execute
from deploy.run.local import LocalFleet
from deploy.run.operator import Operator
from deploy.run.options import Mode, RunOptions, Transport, fresh_run_name
from deploy.run.result import complete
from deploy.telemetry.recording.reader import read
from deploy.telemetry.recording.trajectory import CompactTruth, Trajectory
from disknav.orders import Orders, finite
from disknav.scenarios import Settings, Source, ready
from protocol.arrays import Reals
from protocol.errors import UsageError
from protocol.keys import checked_run
from protocol.messages import Truth
from protocol.process.signals import STOP
from protocol.scenario.model import Scenario


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
    def positions(self) -> Reals:
        """Positions of all present disks, m, shape (p, 2), in the order of ids."""
        return np.array(self._truths[-1].positions)

    @property
    def trajectory(self) -> Trajectory:
        """Trajectory from tick 0 to the current tick."""
        return Trajectory.of(map(CompactTruth.of, self._truths), self.scenario.time.step)

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
                core.on_wish(finite(wish))

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

    def __iter__(self) -> Iterator[Reals]:
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


@dataclass(frozen=True, eq=False, repr=False)
class Run:
    """Result and trajectory of a run.

    Attributes:
        result: the object that `disknav run --json` writes; docs/reference/result.md lists its fields.
        recording: path of the recording, None without `record`.
    """

    scenario: Scenario
    result: Mapping[str, Any]
    trajectory: Trajectory
    recording: Path | None = None

    def __repr__(self) -> str:
        return f"Run({self.scenario.name!r}, {self.verdict}, {self.result['ticks']} ticks)"

    @property
    def verdict(self) -> str:
        """How the run ended: "arrived", "collision", "timeout", "deadlock", "interrupted" or "aborted"."""
        return str(self.result["verdict"])

    @property
    def arrived(self) -> bool:
        """Whether all robots arrived without contact."""
        return self.verdict == "arrived"


def run(
    scenario: Source,
    settings: Settings | None = None,
    *,
    seed: int | None = None,
    transport: Transport = "local",
    mode: Mode = "lockstep",
    record: str | Path | None = None,
    name: str | None = None,
    progress: bool = False,
) -> Run:
    """Run a scenario to its verdict.

    Args:
        scenario: a result of `load` or `build`; or a source for `load`, with `settings` and `seed`.
        transport: "local" for all robots in this process; "routed" or "mesh" for one process each.
        mode: "lockstep", or "realtime" for one tick per period of the wall clock.
        record: path of the recording to write (MCAP).
        name: name of the run; by default a fresh one.
        progress: whether to print a progress bar on standard error.

    The trajectory in lock-step is the same on every transport. Ctrl-C ends the run as "interrupted".

    Raises:
        ScenarioError, UsageError: as `load`; or `settings` or `seed` are given with a finished scenario.
        ProcessError, BusError: the fleet could not be started.
    """
    path = None if record is None else Path(record)
    check_target(path, "record", scenario if isinstance(scenario, str | Path) else None)
    scenario = ready(scenario, settings, seed)
    if transport != "local" and scenario.control.law.startswith("__main__:"):
        raise UsageError(
            f"the processes of a fleet cannot import {scenario.control.law!r} from this script or notebook: "
            'put the class into a module, or name its file, control.law = "law.py:Class"'
        )
    options = RunOptions(transport, mode, run=fresh_run_name() if name is None else checked_run(name))
    if transport == "local" and mode == "lockstep" and record is None and not progress:
        simulation = Simulation(scenario, name=options.run)
        return Run(scenario, complete(simulation.finish(), options, []), simulation.trajectory)
    with ExitStack() as stack:
        folder = stack.enter_context(TemporaryDirectory(prefix="disknav-"))
        path = path or Path(folder) / "run.mcap"
        result = execute(scenario, options, record=path, quiet=not progress)
        trajectory = read(path).trajectory
    if record is None:
        return Run(scenario, {**result, "recordings": []}, trajectory)
    return Run(scenario, result, trajectory, path)
