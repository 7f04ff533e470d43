"""Fleets on wheels in MuJoCo that swap places, with everything that can go wrong on the way.

python -m tests.world.plants.campaign --runs 200
python -m tests.world.plants.campaign --runs 10 --naive     (robots that take their bodies for points)

Each run is drawn from its seed alone: --first N --runs 1 repeats one.
Exit status: 0 if nothing touched, 1 otherwise.
"""

from __future__ import annotations

import argparse
import sys
import time

from tests.world.plants.fleet import drive, varied


def main() -> int:
    """Run a campaign; returns the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--runs", type=int, default=200, help="how many")
    parser.add_argument("--first", type=int, default=0, help="seed of the first")
    parser.add_argument("--naive", action="store_true", help="the negative control")
    options = parser.parse_args()
    touched = arrived = 0
    began, nearest = time.monotonic(), float("inf")
    for number in range(options.runs):
        setting = varied(options.first + number)
        report = drive(setting, options.naive)
        nearest = min(nearest, report["min_clearance"])
        touched += report["verdict"] == "collision"
        arrived += len(report["arrived"]) == setting.robots
        if report["verdict"] != "arrived":
            print(f"{report['verdict']} ({report['reason']}): {setting}", flush=True)
        seconds = time.monotonic() - began
        counts = f"{touched} with contact, {arrived} arrived, smallest gap {nearest * 1e3:.3g} mm"
        print(f"{number + 1} runs in {seconds:.0f} s: {counts}", flush=True)
    return int(touched > 0)


if __name__ == "__main__":
    sys.exit(main())
