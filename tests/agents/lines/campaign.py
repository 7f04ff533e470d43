"""Random runs of the models by the hundred thousand, or the table of rules, mutants and what finds them.

python -m tests.agents.lines.campaign --runs 100000
python -m tests.agents.lines.campaign --model skirmish --runs 5000
python -m tests.agents.lines.campaign --mutants

Each run is drawn from its seed alone: --first N --runs 1 repeats one.
Exit status: 0 no violation, and one for every mutant; 1 otherwise.
"""

from __future__ import annotations

import argparse
import sys
import time

from deploy.output.bar import bar
from tests.agents.lines import skirmish, walk
from tests.agents.lines.mutants import MUTANTS, hunt
from tests.agents.lines.product import Product

_MODELS = {"walk": walk.violation_of, "skirmish": skirmish.violation_of}


def main() -> int:
    """Run a campaign; returns the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--model", choices=_MODELS, default="walk", help="the track, or whole robots")
    parser.add_argument("--runs", type=int, default=100_000, help="how many")
    parser.add_argument("--first", type=int, default=0, help="seed of the first")
    parser.add_argument("--mutants", action="store_true", help="the product without each rule, instead")
    options = parser.parse_args()
    return _table() if options.mutants else _runs(options.model, options.first, options.runs)


def _runs(model: str, first: int, runs: int) -> int:
    product, violated, began = Product(), 0, time.monotonic()
    with bar(model) as show:
        for number in range(runs):
            violation = _MODELS[model](first + number, product)
            if violation:
                violated += 1
                print(f"seed {first + number}: {violation}", flush=True)
            show((number + 1) / runs)
    print(f"{runs} runs of the {model} in {time.monotonic() - began:.0f} s, {violated} with a violation")
    return int(violated > 0)


def _table() -> int:
    """Print rule, model, and how many runs or states it took to find a violation."""
    missed = 0
    for mutant in MUTANTS:
        tried, violation = hunt(mutant)
        missed += not violation
        unit = "states" if mutant.model == "pair" else "runs"
        print(
            f"{mutant.rule:<36}{mutant.model:<10}{tried:>8} {unit:<8}{violation or 'NOT FOUND'}", flush=True
        )
    return int(missed > 0)


if __name__ == "__main__":
    sys.exit(main())
