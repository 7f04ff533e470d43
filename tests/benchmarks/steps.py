"""What a step of each law costs a robot with all that belongs to it: decoding, lines, law, filter, encoding.

Mean processor time of a robot and tick over whole runs on the in-process bus, in microseconds; the least of
several runs. ORCA is pyrvo with one simulator a robot, without a filter.

    python -m tests.benchmarks.steps --robots 12 32 --delay 0 0.3
"""

import argparse
import time
from dataclasses import replace

from deploy.library.instances import random_instance
from deploy.library.load import resolved
from deploy.run.local import LocalFleet
from protocol.bus.bus import Event, Node
from protocol.scenario.model import Scenario
from protocol.scenario.network import Link
from tests.proxy import Proxy

LAWS = {
    "reciprocal": "separating-lines",
    "gradient": "separating-lines",
    "deploy.studies.peers.laws:Orca": "none",
}


class MeteredFleet(LocalFleet):
    """With a counter of the processor time that robots spend on messages, ns, without world and bus."""

    cpu = 0

    def start(self, robot: int) -> Node:
        node = super().start(robot)

        def handle(event: Event) -> None:
            began = time.thread_time_ns()
            node.handle(event)
            self.cpu += time.thread_time_ns() - began

        self.robots[robot].node = Proxy(node, handle=handle)
        return node


def step(scenario: Scenario, runs: int) -> float:
    """Of a robot, µs."""
    least = float("inf")
    for _ in range(runs):
        fleet = MeteredFleet(scenario)
        report = fleet.execute()
        least = min(least, 1e-3 * fleet.cpu / (report["ticks"] * len(scenario.robots)))
    return least


def crowd(robots: int, law: str, delay: float) -> Scenario:
    """Random starts and goals at the paper's density, for ten seconds at most."""
    base = random_instance(robots, 1)
    return resolved(
        replace(
            base,
            control=replace(base.control, law=law, filter=LAWS[law]),  # type: ignore[arg-type]
            link=Link(delay=delay),
            time=replace(base.time, limit=10.0),
        )
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--robots", type=int, nargs="+", default=[12, 32])
    parser.add_argument("--delay", type=float, nargs="+", default=[0.0, 0.3], help="s")
    parser.add_argument("--runs", type=int, default=3)
    asked = parser.parse_args()
    print("robots  delay, s  " + "  ".join(f"{law.rpartition(':')[2]:>10}" for law in LAWS))
    for robots in asked.robots:
        for delay in asked.delay:
            costs = [step(crowd(robots, law, delay), asked.runs) for law in LAWS]
            print(f"{robots:6}  {delay:8g}  " + "  ".join(f"{cost:10.0f}" for cost in costs))


if __name__ == "__main__":
    main()
