"""What the robots of an in-process run compute, without the world and the bus."""

from __future__ import annotations

import time

from agents.shell.node import RobotNode
from deploy.run.local import LocalFleet
from protocol.bus.events import Event


class MeteredNode:
    """A robot whose CPU time for all that it hears is counted: decode, hear, decide, encode, publish."""

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
    """A fleet of such robots."""

    def start(self, robot: int) -> MeteredNode:
        bus = self.robots[robot] = self.network.connect()
        node = bus.node = MeteredNode(RobotNode(bus, self.run, robot))
        return node

    def robots_cpu(self) -> float:
        """CPU of the robots that are there now, s."""
        nodes = [bus.node for bus in self.robots.values()]
        return 1e-9 * sum(node.cpu_ns for node in nodes if isinstance(node, MeteredNode))
