"""Bytes on the links between hosts, with robots that receive near States only and with such that receive all.

Hosts are network namespaces at a switch, with a router each. Robots go for ever between random places in a
part of the workspace of their own host's. Counted is what hosts send, frames with all their headers, after
the first two seconds; `bytes` are of all links together, per tick and robot. Needs root and iproute2.

    python -m tests.benchmarks.links --hosts 4 --robots 64
"""

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from deploy.library.instances import random_instance
from deploy.library.load import resolved
from protocol.draws import Purpose, generator
from protocol.scenario.model import Position, Scenario
from protocol.scenario.network import Network
from tests.benchmarks.crowds import patrols
from tests.system.hosts.testbed.network import Hosts, unable

_LEGS = 6  # goals of each robot, which it goes to in turn for ever
_LIMIT = 12.0  # s of simulated time
_WARM = 2.0  # s of it before bytes are counted
_SPARE = 0.5  # s, likewise after: a loaded machine drops some Truths, the last one too


def homes(scenario: Scenario, hosts: int) -> dict[int, int]:
    """Which host each robot is on, from 1 on: parts of the workspace with as many robots each."""
    found: dict[int, int] = {}

    def divide(robots: list[tuple[Position, int]], first: int, count: int, axis: int) -> None:
        if count == 1:
            found.update((robot, first) for _, robot in robots)
            return
        robots.sort(key=lambda each: (each[0][axis], each[1]))
        half = count // 2
        middle = len(robots) * half // count
        divide(robots[:middle], first, half, 1 - axis)
        divide(robots[middle:], first + half, count - half, 1 - axis)

    divide([(spec.start, spec.id) for spec in scenario.robots], 1, hosts, 0)
    return found


def in_blocks(robots: int, hosts: int, network: Network) -> Scenario:
    """Random robots for ever under way between the starts of all that are on the same host."""
    instance = random_instance(robots, 0)
    at = homes(instance, hosts)
    random = generator(0, Purpose.SCENARIO, 9)
    legs: dict[int, list[Position]] = {spec.id: [] for spec in instance.robots}
    for host in range(1, hosts + 1):
        block = [spec for spec in instance.robots if at[spec.id] == host]
        for _ in range(_LEGS):
            for spec, other in zip(block, random.permutation(len(block)), strict=True):
                legs[spec.id].append(block[other].start)
    clock = replace(instance.time, limit=_LIMIT)
    return resolved(replace(instance, time=clock, orders=patrols(legs), network=network))


def measure(scenario: Scenario, count: int) -> dict[int, float]:
    """Bytes per tick that each of `count` hosts sends in one run, in lock-step."""
    with TemporaryDirectory(prefix="disknav-") as name, Hosts(count, Path(name) / "log") as hosts:
        told = hosts.fleet(scenario, homes(scenario, count), lockstep=True)
        return _followed(scenario, hosts, told)


def _followed(scenario: Scenario, hosts: Hosts, told: Iterator[dict[str, object]]) -> dict[int, float]:
    begin, end = scenario.ticks(_WARM), scenario.ticks(scenario.time.limit - _SPARE)
    first: tuple[int, dict[int, int]] | None = None
    last: tuple[int, dict[int, int]] | None = None
    for each in told:
        tick = each.get("tick", 0)
        if tick >= begin and first is None:
            first = tick, hosts.sent()
        elif tick >= end and last is None:
            last = tick, hosts.sent()
        report = each.get("report")
        if not isinstance(report, dict):
            continue
        if first is not None and last is not None:
            return {host: (last[1][host] - first[1][host]) / (last[0] - first[0]) for host in last[1]}
        raise RuntimeError(f"the run ended before its time: {report['verdict']}, {report['reason']}")
    raise RuntimeError("no report of the run")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--robots", type=int, nargs="+", default=[64])
    parser.add_argument("--hosts", type=int, default=4)
    chosen = parser.parse_args()
    if (problem := unable()) is not None:
        parser.error(problem)
    print("robots  hosts  interest   bytes  ratio   world's host   largest other")
    for robots in chosen.robots:
        whole = 0.0
        for interest in ("all", "near"):
            sent = measure(in_blocks(robots, chosen.hosts, Network(interest)), chosen.hosts)
            each = sum(sent.values()) / robots
            whole = whole or each
            world, *others = (sent[host] for host in sorted(sent))
            print(
                f"{robots:6d}  {chosen.hosts:5d}  {interest:>8}  {each:6.0f}"
                f"  {each / whole:5.3f}  {world:13.0f}  {max(others):14.0f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
