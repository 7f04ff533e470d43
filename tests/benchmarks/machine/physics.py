"""How fast fleets on wheels go in MuJoCo, beside the same fleets of points: whole swaps in lock-step, with
real processes and a router.

The factor is simulated time per wall time, the processor time that of all processes; `plant` is what of it
the plant itself takes. Time is until all have arrived, or no robot moves any more; path is the mean of all
robots; in brackets both are beside points.

    python -m tests.benchmarks.machine.physics --robots 6 16 32
"""

import argparse
import time
from statistics import mean
from typing import NamedTuple

from deploy.library.load import load
from deploy.run.fleet import Fleet
from deploy.run.options import RunOptions
from protocol.scenario.model import Scenario
from world.plants.plant import plant_of

ASKED = {6: 10.0, 16: 4.0, 32: 2.0}  # times real time
KINDS = {"points": ("body=point",), "wheels in formulas": (), "wheels in MuJoCo": ("world.plant=mujoco",)}
_TICKS = 100  # of the plant alone


class Swap(NamedTuple):
    """One swap: simulated s per s, ms of processor time per tick, of those the plant's, s and m, and how many
    robots arrived."""

    factor: float
    cpu_ms: float
    plant_ms: float
    time: float
    path: float
    arrived: int


def swap(robots: int, kind: str) -> Swap:
    """Have a fleet change places.

    Raises:
        RuntimeError: two robots touched.
    """
    scenario = load(f"turtlebots-{robots}", KINDS[kind])
    with Fleet(scenario, RunOptions()) as fleet:
        report = fleet.execute()
        cpu = sum(process["cpu_s"] for process in fleet.processes())
    if report["verdict"] == "collision":
        raise RuntimeError(f"{scenario.name}, {kind}: {report['reason']}")
    return Swap(
        report["sim_time"] / report["wall_time"],
        1e3 * cpu / report["ticks"],
        plant_ms(scenario),
        report["sim_time"],
        mean(report["path_lengths"].values()),
        len(report["arrived"]),
    )


def plant_ms(scenario: Scenario) -> float:
    """What a tick takes the plant alone, with all robots on the way to the goal, ms."""
    plant = plant_of(scenario)
    velocities = {spec.id: (0.1 * spec.goal[0], 0.1 * spec.goal[1]) for spec in scenario.robots}
    began = time.process_time()
    for tick in range(_TICKS):
        plant.move(velocities, tick)
    return 1e3 * (time.process_time() - began) / _TICKS


def line(robots: int, kind: str, found: Swap, floor: Swap) -> str:
    asked = f"{ASKED[robots]:g}" if kind == "wheels in MuJoCo" and robots in ASKED else ""
    cost = f"{found.factor:8.1f}{asked:>7}{found.cpu_ms:13.2f}{found.plant_ms:7.2f}{found.arrived:9}"
    way = (
        f"{found.time:9.1f} ({found.time / floor.time:.2f}){found.path:8.2f} ({found.path / floor.path:.2f})"
    )
    return f"{robots:6} {kind:<20}{cost}{way}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--robots", type=int, nargs="+", default=list(ASKED))
    options = parser.parse_args()
    print(f"robots{'factor':>29}  asked  cpu ms/tick  plant  arrived     time, s         path, m")
    for robots in options.robots:
        floor = swap(robots, "points")
        print(line(robots, "points", floor, floor), flush=True)
        for kind in list(KINDS)[1:]:
            print(line(robots, kind, swap(robots, kind), floor), flush=True)


if __name__ == "__main__":
    main()
