"""A search for livelock: scenarios in which the paper's law arrives and the reciprocal one does not.

    python -m tests.agents.laws.campaign --runs 2000

Random starts and goals, equal and unequal disks, crowded and not, swaps with and without jitter, fresh and
late states. Every instance on which the reciprocal law does not arrive is run with the paper's law; the exit
status is 1 if that arrives on any.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from dataclasses import replace

from deploy.library.load import resolved
from deploy.library.random_instances import random_instance
from deploy.library.swaps import swap
from deploy.run.local import LocalFleet
from protocol.draws import Purpose, generator
from protocol.scenario.model import Control, Link, Scenario

LIMIT = 120.0  # s of simulated time
DELAYS = (0.0, 0.0, 0.05, 0.1, 0.2, 0.3)  # s; fresh states twice as often


def drawn(seed: int) -> Scenario:
    """One instance, without a law."""
    random = generator(seed, Purpose.SCENARIO, 7)
    count, kind = int(random.integers(2, 13)), int(random.integers(3))
    if kind == 0:
        scenario = swap(count, 0.015 * random.random() * float(random.integers(2)), seed)
    else:
        unequal = 0.5 * random.random() * (kind - 1)
        scenario = random_instance(count, seed, density=random.uniform(0.03, 0.3), unequal=unequal)
    delay = DELAYS[int(random.integers(len(DELAYS)))]
    time = replace(scenario.time, limit=LIMIT, deadlock=LIMIT)
    return replace(scenario, link=Link(delay=delay), time=time)


def arrives(scenario: Scenario, law: str) -> bool:
    """Whether all robots do.

    Raises:
        AssertionError: something touched.
    """
    control = Control(law=law)
    (report,) = LocalFleet([resolved(replace(scenario, control=control))]).execute()
    assert report["collisions"] == 0, f"{law} touches in {scenario.name} of seed {scenario.seed}"
    return bool(report["verdict"] == "arrived")


def main() -> int:
    """The instances, and how many there were of each outcome."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    outcomes: Counter[str] = Counter()
    for seed in range(asked.seed, asked.seed + asked.runs):
        scenario = drawn(seed)
        outcome = "arrived"
        if not arrives(scenario, "reciprocal"):
            outcome = "only with gradient" if arrives(scenario, "gradient") else "with neither"
            print(f"seed {seed}: {outcome}: {scenario.description}, {scenario.link.delay} s late", flush=True)
        outcomes[outcome] += 1
    print(", ".join(f"{name}: {count}" for name, count in sorted(outcomes.items())))
    return int(outcomes["only with gradient"] > 0)


if __name__ == "__main__":
    sys.exit(main())
