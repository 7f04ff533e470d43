"""Random rides of every body by the million ticks, or the table of rules, mutants and what finds them.

python -m tests.agents.bodies.campaign --ticks 1000000
python -m tests.agents.bodies.campaign --body differential-drive --ticks 1000000
python -m tests.agents.bodies.campaign --mutants

Each ride is drawn from its seed alone. Exit status: 0 no excess, and one for every mutant; 1 otherwise.
"""

from __future__ import annotations

import argparse
import sys
import time

from deploy.output.bar import bar
from tests.agents.bodies.mutants import MUTANTS, hunt
from tests.agents.bodies.ride import KINDS, ROUNDING, TICKS, Product, excess_of


def main() -> int:
    """Run a campaign; returns the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--body", choices=KINDS, help="only this one")
    parser.add_argument("--ticks", type=int, default=1_000_000, help="of each body")
    parser.add_argument("--mutants", action="store_true", help="the product without each rule, instead")
    options = parser.parse_args()
    if options.mutants:
        return _table()
    return max(_rides(kind, options.ticks) for kind in KINDS if options.body in (None, kind))


def _rides(kind: str, ticks: int) -> int:
    product, worst, began = Product(), -float("inf"), time.monotonic()
    with bar(kind) as show:
        for seed in range(-(-ticks // TICKS)):
            excess = excess_of(seed, kind, product)
            if excess > ROUNDING:
                print(f"{kind}, seed {seed}: beyond by {excess:.3g} m", flush=True)
            worst = max(worst, excess)
            show((seed + 1) * TICKS / ticks)
    print(
        f"{kind}: {ticks} ticks in {time.monotonic() - began:.0f} s, excess at most {worst:.2g} m", flush=True
    )
    return int(worst > ROUNDING)


def _table() -> int:
    """Print each rule, how many rides it took to find its mutant, and by how much it is beyond."""
    missed = 0
    for mutant in MUTANTS:
        rides, excess = hunt(mutant)
        missed += excess <= ROUNDING
        print(f"{mutant.rule:<20}{mutant.kind:<20}{rides:>6} rides {excess:.3g} m", flush=True)
    return int(missed > 0)


if __name__ == "__main__":
    sys.exit(main())
