"""Ticks of a fleet among very many boxes against those of the same fleet in an empty room, in turns.

python -m tests.benchmarks.obstacles --boxes 3000 --robots 50
"""

import argparse
import math
import time
from random import Random
from statistics import median

import disknav
from tests.benchmarks.steps import MeteredFleet

_PITCH = 1.09  # m, between centres of boxes
_SETTLED = 5  # ticks until all are bound to what is near


class Fleet:
    """One fleet, and what its ticks took.

    Attributes:
        whole: processor time of each tick, s.
        robots: the part of it in which robots handled messages, s.
    """

    def __init__(self, boxes: int, robots: int, sites: int) -> None:
        self.whole: list[float] = []
        self.robots: list[float] = []
        random, n = Random(1), math.ceil(math.sqrt(sites)) + 1
        side, cells = n * _PITCH, [(i, j) for i in range(n) for j in range(n)]
        corners = [(i * _PITCH, j * _PITCH) for i in range(1, n) for j in range(1, n)]
        random.shuffle(cells)
        random.shuffle(corners)
        obstacles = []
        for i, j in cells[:boxes]:
            x, y, half = (i + 0.5) * _PITCH, (j + 0.5) * _PITCH, random.uniform(0.12, 0.22)
            obstacles.append({"points": [(x + half * a, y + half * b) for a, b in _CORNERS]})
        scenario = disknav.build(
            {
                "workspace": {"points": [(side * (a + 1) / 2, side * (b + 1) / 2) for a, b in _CORNERS]},
                "time": {"step": 0.1, "limit": 1000.0},
                "control": {"speed": 0.5},
                "robots": [
                    {"id": each + 1, "radius": 0.2, "start": corners[2 * each], "goal": corners[2 * each + 1]}
                    for each in range(robots)
                ],
                "obstacles": obstacles,
            }
        )
        self._fleet = MeteredFleet(scenario)
        for _ in range(_SETTLED):
            self._fleet.step()

    def step(self) -> None:
        before, begun = self._fleet.cpu, time.process_time()
        self._fleet.step()
        self.whole.append(time.process_time() - begun)
        self.robots.append(1e-9 * (self._fleet.cpu - before))


_CORNERS = ((-1, -1), (1, -1), (1, 1), (-1, 1))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--boxes", type=int, default=3000, help="convex obstacles")
    parser.add_argument("--robots", type=int, default=50, help="in either fleet")
    parser.add_argument("--ticks", type=int, default=60, help="of either fleet, in turns")
    options = parser.parse_args()
    fleets = [Fleet(boxes, options.robots, options.boxes) for boxes in (0, options.boxes)]
    for _ in range(options.ticks):
        for fleet in fleets:
            fleet.step()
    print(f"{'ms for a robot and tick':>24} {'empty':>7} {'boxes':>7} {'ratio':>6}")
    for name in ("robots", "whole"):
        empty, boxes = (1e3 * median(getattr(fleet, name)) / options.robots for fleet in fleets)
        print(f"{name:>24} {empty:7.2f} {boxes:7.2f} {boxes / empty:6.2f}")


if __name__ == "__main__":
    main()
