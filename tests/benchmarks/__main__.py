"""Rates and costs of real fleets, as ratios against floors measured in the same run.

python -m tests.benchmarks --robots 6 16 --seconds 2
"""

import argparse
from collections import defaultdict
from functools import cache
from statistics import mean

from deploy.run.local import LocalFleet
from deploy.run.options import RunOptions
from protocol.keys import everything, parse
from protocol.scenario.network import Network
from tests.benchmarks import bare
from tests.benchmarks.bare import Payloads, Rate
from tests.benchmarks.crowds import Measured, measure, restless
from tests.listening import overhear

ROBOTS = (6, 16, 32, 64)
_HEAD = (
    f"{'robots':>6} {'':<16} {'ticks/s':>8} {'ratio':>6} {'cpu ms/tick':>12} {'ratio':>6} {'us/state':>9}"
    f" {'start s':>8} {'kB a robot':>11}"
)


def measured(robots: int, seconds: float) -> dict[str, Measured | Rate]:
    """By name. On bare floors robots receive all States, in larger fleets those of near peers."""
    fleets = {"fleet": restless(robots), "fleet, all heard": restless(robots, network=Network("all"))}
    found = {name: measure(scenario, RunOptions(), seconds) for name, scenario in fleets.items()}
    return {"bare zenoh": bare.rate(robots, payloads(robots), seconds), **found}


@cache
def payloads(robots: int) -> Payloads:
    """As many bytes as the messages of the fleet that is measured have on average, in its first seconds."""
    fleet, sizes = LocalFleet(restless(robots, seconds=5.0)), defaultdict[str, list[int]](list)
    overhear(
        fleet.network, lambda key, said: sizes[parse(key).stream].append(len(said)), everything(fleet.run)
    )
    fleet.execute()
    return Payloads(*(name[0].encode().ljust(round(mean(sizes[name])), b"\0") for name in Payloads._fields))


def table(robots: int, results: dict[str, Measured | Rate]) -> str:
    floor = results["bare zenoh"]
    lines = []
    for name, result in results.items():
        line = (
            f"{robots:6d} {name:<17}{result.ticks_per_second:8.0f}"
            f" {result.ticks_per_second / floor.ticks_per_second:6.2f} {result.cpu_ms:12.2f}"
            f" {floor.cpu_ms / result.cpu_ms:6.2f} {1000.0 * result.cpu_ms / (robots * (robots - 1)):9.1f}"
        )
        if isinstance(result, Measured):
            line += f" {result.start:8.2f} {result.memory:11.0f}"
        lines.append(line)
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--robots", type=int, nargs="+", default=ROBOTS, help="numbers of robots")
    parser.add_argument("--seconds", type=float, default=3.0, help="how long each is measured")
    options = parser.parse_args()
    print(_HEAD, flush=True)
    for robots in options.robots:
        print(table(robots, measured(robots, options.seconds)), flush=True)


if __name__ == "__main__":
    main()
