"""A worker process of a study: one run at a time, in the process itself or as a fleet of its own."""

from __future__ import annotations

import multiprocessing
import os
import time
import traceback
from multiprocessing.connection import Connection as Channel
from typing import Any

import psutil

from agents.shell.node import RobotNode
from deploy.processes.fork_server import end_with_pipe
from deploy.run.fleet import Fleet
from deploy.run.local import LocalFleet
from deploy.run.options import RunOptions, Transport
from deploy.run.result import complete
from deploy.studies.study import Build, Result
from protocol.bus.bus import Event
from protocol.process.log import set_process_title

FAILED = "failed"  # verdict of a run that ended with an exception: a bug, never a result
# Of a result, which says more than a study needs:
# fmt: off
KEPT = (
    "seed", "verdict", "reason", "arrived", "collisions", "contacts", "min_clearance",
    "nrl", "tight", "k", "robots", "ticks", "sim_time", "wall_time",
    "ticks_per_second", "missed_commands", "down", "positions", "trajectory_sha256", "cpu_s", "robots_cpu_s",
    "max_rss_mb", "processes",
)
# fmt: on


def begin(lifeline: Channel[Any, Any]) -> None:
    """Have this process end with the other end of `lifeline`; Ctrl-C is for the parent to handle."""
    set_process_title(f"study worker {multiprocessing.current_process().name.rpartition('-')[2]}")
    end_with_pipe(os.dup(lifeline.fileno()))
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def execute(build: Build, seed: int, transport: Transport) -> Result:
    """One run: of its result what a study needs.

    Raises:
        ProcessError, BusError: a process of the fleet did not start.
    """
    result = _in_process(build, seed) if transport == "local" else _on_processes(build, seed, transport)
    return {name: result[name] for name in KEPT if name in result}


def _in_process(build: Build, seed: int) -> Result:
    began = time.thread_time()
    try:
        fleet = MeteredFleet(build(seed))
        report = fleet.execute()
    except Exception:  # noqa: BLE001  one run that fails must be reported beside the thousands that do not
        return {"seed": seed, "verdict": FAILED, "reason": traceback.format_exc(limit=-3)}
    result = complete(report, RunOptions("local"), [])
    result["cpu_s"] = time.thread_time() - began
    result["robots_cpu_s"] = fleet.robots_cpu()
    result["max_rss_mb"] = psutil.Process().memory_info().rss / 2**20
    return result


def _on_processes(build: Build, seed: int, transport: Transport) -> Result:
    options = RunOptions(transport)
    with Fleet(build(seed), options) as fleet:
        report = fleet.execute()
        return complete(report, options, fleet.processes())


class MeteredNode:
    """A robot whose CPU time for every message is counted: decode, update, decide, encode, publish."""

    def __init__(self, node: RobotNode) -> None:
        self._node = node
        self.cpu_ns = 0

    def handle(self, event: Event) -> None:
        began = time.thread_time_ns()
        self._node.handle(event)
        self.cpu_ns += time.thread_time_ns() - began

    def wake(self, now: float) -> None:
        self._node.wake(now)

    @property
    def deadline(self) -> float:
        return self._node.deadline

    @property
    def finished(self) -> bool:
        return self._node.finished


class MeteredFleet(LocalFleet):
    """An in-process fleet of such robots."""

    def start(self, robot: int) -> MeteredNode:
        bus = self.robots[robot] = self.network.connect()
        node = bus.node = MeteredNode(RobotNode(bus, self.run, robot))
        return node

    def robots_cpu(self) -> float:
        """CPU of the robots that are there now, s; without the world and the bus."""
        nodes = [bus.node for bus in self.robots.values()]
        return 1e-9 * sum(node.cpu_ns for node in nodes if isinstance(node, MeteredNode))
