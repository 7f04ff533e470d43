"""What the robots of an in-process run compute, without the world and the bus."""

from __future__ import annotations

import time

from agents.node import RobotNode
from deploy.local import LocalFleet
from protocol.bus import Event


class MeteredNode(RobotNode):
    """A robot that counts the CPU time of all that it does: decode, hear, decide, encode, publish."""

    cpu_ns = 0

    def handle(self, event: Event) -> None:
        began = time.thread_time_ns()
        super().handle(event)
        self.cpu_ns += time.thread_time_ns() - began


class MeteredFleet(LocalFleet):
    """A fleet of such robots."""

    def start(self, robot: int) -> None:
        bus = self.robots[robot] = self.network.connect()
        bus.node = MeteredNode(bus, self.run, robot)

    def robots_cpu(self) -> float:
        """CPU of the robots that are there now, s."""
        nodes = [bus.node for bus in self.robots.values()]
        return 1e-9 * sum(node.cpu_ns for node in nodes if isinstance(node, MeteredNode))
