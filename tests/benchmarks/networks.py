"""What networks as they are cost in time: the scenarios of `study delay` under each preset, against no delay.

python -m tests.benchmarks.networks --runs 5
"""

import argparse
from dataclasses import replace

from deploy.library.load import resolved
from deploy.run.local import LocalFleet
from deploy.studies.conditions import LIMIT, PACES, PLACES, Pace
from deploy.studies.study import Build
from protocol.scenario.network import WIRELESS, Link


def time_of(build: Build, pace: Pace, link: Link, seed: int) -> float | None:
    """Simulated time until all arrive, s; None if they do not. Nothing may touch."""
    scenario = build(seed)
    control = scenario.control if pace == "common" else scenario.control.without("pace")
    time = replace(scenario.time, limit=LIMIT)
    report = LocalFleet(resolved(replace(scenario, control=control, link=link, time=time))).execute()
    assert report["collisions"] == 0, f"seed {seed} under {link}"
    return float(report["sim_time"]) if report["verdict"] == "arrived" else None


def main() -> None:
    """Print a table: mean ratio of the seeds that arrived with and without the network, and how many did."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--runs", type=int, default=5, help="starts of each scenario")
    seeds = range(parser.parse_args().runs)
    for name, build in PLACES.items():
        for pace in PACES:
            plain = [time_of(build, pace, Link(), seed) for seed in seeds]
            for preset in WIRELESS:
                late = [time_of(build, pace, Link(preset=preset), seed) for seed in seeds]
                ratios = [a / b for a, b in zip(late, plain, strict=True) if a is not None and b is not None]
                mean = sum(ratios) / max(1, len(ratios))
                print(f"{name:<12} {pace:<7} {preset:<15} {mean:5.2f} of {len(ratios)} starts", flush=True)


if __name__ == "__main__":
    main()
