"""Damaged inputs by the million, for everything that reads what strangers wrote.

python -m tests.fuzz --inputs 1000000

Inputs are valid ones, taken from real runs and from the library, with bytes, characters or values
changed. Each is drawn from the seed and its number alone: --first N --inputs 1 repeats one.
Exit status: 0 nothing but declared errors, 1 something else, and the input is saved.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

from deploy.output.bar import bar
from tests.fuzz.campaign import Tally, campaign
from tests.fuzz.catalogue import TARGETS


def report(tally: Tally, seconds: float) -> str:
    """A line for each reader, and one for all."""
    lines = [f"{'':<10}{'inputs':>10}{'accepted':>10}{'refused':>10}"]
    for name in TARGETS:
        accepted, refused = tally.accepted[name], tally.refused[name]
        lines.append(f"{name:<10}{accepted + refused:>10}{accepted:>10}{refused:>10}")
    total = tally.accepted.total() + tally.refused.total() + tally.found
    rate = total / seconds if seconds else 0.0
    lines.append(
        f"{total} inputs in {seconds:.0f} s, {rate:.0f} per second; the slowest took "
        f"{1000.0 * tally.slowest:.0f} ms; {tally.found} undeclared errors"
    )
    return "\n".join(lines)


def main() -> int:
    """Run a campaign; returns the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--inputs", type=int, default=100_000, help="how many")
    parser.add_argument("--first", type=int, default=0, help="number of the first")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--save", type=Path, default=Path("out/fuzz"), help="folder for what is found")
    options = parser.parse_args()
    began = time.monotonic()
    with bar("fuzz") as tell:
        numbers = range(options.first, options.first + options.inputs)
        tally = campaign(options.seed, numbers, lambda done: tell(done / options.inputs))
    print(report(tally, time.monotonic() - began))
    for finding in tally.findings.values():
        options.save.mkdir(parents=True, exist_ok=True)
        path = options.save / f"{finding.target}-{options.seed}-{finding.number}.txt"
        path.write_text(str(finding), encoding="utf-8", errors="backslashreplace")
        last = finding.error.strip().rpartition("\n")[2]
        print(f"{path}: {last[:200]}; again with --seed {options.seed} --first {finding.number} --inputs 1")
    return 1 if tally.found else 0


if __name__ == "__main__":
    sys.exit(main())
