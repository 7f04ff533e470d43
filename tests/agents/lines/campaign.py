"""Random runs of the models by the hundred thousand, or the table of rules, mutants and what finds them.

python -m tests.agents.lines.campaign --runs 100000 --log out/campaign.json
python -m tests.agents.lines.campaign --model skirmish --runs 5000
python -m tests.agents.lines.campaign --mutants --first 0

Each run is drawn from its seed alone: --first N --runs 1 repeats one. With --log the same command goes on
where it was stopped.
Exit status: 0 no violation, and one for every mutant; 1 otherwise.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path

from deploy.output.bar import bar
from tests.agents.lines.models import walk
from tests.agents.lines.models.mutants.catalogue import MUTANTS
from tests.agents.lines.models.mutants.mutant import hunt
from tests.agents.lines.models.product import Product
from tests.agents.lines.models.skirmishes import aftermath, skirmish

_KEPT = 200  # runs after which it is noted how far it has come
_MODELS = {"walk": walk.violation_of, "skirmish": skirmish.violation_of, "aftermath": aftermath.violation_of}


def main() -> int:
    """Run a campaign; returns the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument(
        "--model", choices=_MODELS, default="walk", help="track, whole robots, or what follows"
    )
    parser.add_argument("--runs", type=int, default=100_000, help="how many")
    parser.add_argument("--first", type=int, help="seed of the first; 0, or the mutant's own")
    parser.add_argument("--mutants", action="store_true", help="the product without each rule, instead")
    parser.add_argument("--log", type=Path, help="file that says how far it has come")
    options = parser.parse_args()
    if options.mutants:
        return _table(options.first)
    return _runs(options.model, options.first or 0, options.runs, options.log)


def _runs(model: str, first: int, runs: int, log: Path | None) -> int:
    product, violated, began = Product(), _violated(model, first, log), time.monotonic()
    known = len(violated)
    with bar(model) as show:
        for number in range(known, runs):
            violation = _MODELS[model](first + number, product)
            violated.append(bool(violation))
            if violation:
                print(f"seed {first + number}: {violation}", flush=True)
            if log is not None and (len(violated) % _KEPT == 0 or len(violated) == runs):
                kept = {"model": model, "first": first, "violated": "".join("01"[each] for each in violated)}
                log.parent.mkdir(parents=True, exist_ok=True)
                log.write_text(json.dumps(kept))
            show((number + 1) / runs)
    took = time.monotonic() - began
    print(
        f"{len(violated)} runs of the {model}, {sum(violated)} with a violation; {took:.0f} s for the last "
        f"{len(violated) - known}"
    )
    return int(any(violated))


def _violated(model: str, first: int, log: Path | None) -> list[bool]:
    """Of every run that is known from before, whether there was a violation."""
    if log is None or not log.exists():
        return []
    kept = json.loads(log.read_text())
    if (kept["model"], kept["first"]) != (model, first):
        raise SystemExit(f"{log} is of another campaign: {kept['model']} from seed {kept['first']} on")
    return [each == "1" for each in kept["violated"]]


def _table(first: int | None) -> int:
    """Print rule, model, and how many runs from `first` on, or states, it took to find a violation."""
    missed = 0
    for mutant in MUTANTS:
        tried, violation = hunt(mutant, first)
        missed += not violation
        unit = "states" if mutant.model == "pair" else "runs"
        print(
            f"{mutant.rule:<36}{mutant.model:<10}{tried:>8} {unit:<8}{violation or 'NOT FOUND'}", flush=True
        )
    return int(missed > 0)


if __name__ == "__main__":
    sys.exit(main())
