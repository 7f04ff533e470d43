"""Campaigns: random runs by the thousand in search of a violation.

python -m tests.campaigns                                          (lists them)
python -m tests.campaigns falsify --runs 20000 --jobs 2 --minutes 10

Most change parts of the product, and need its sources alone: `make sources` removes what was compiled.
--seed N --runs 1 repeats one run. Exit status: 0 no violation; 1 otherwise.
"""

import argparse
import os
import sys
from functools import partial
from math import inf
from pathlib import Path

from tests.campaigns.catalogue import CAMPAIGNS, find
from tests.campaigns.driver import execute

_say = partial(print, flush=True)


def main(words: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("name", nargs="?", choices=CAMPAIGNS, metavar="NAME", help="which campaign")
    parser.add_argument("--runs", type=int, help="how many; each campaign has its own default")
    parser.add_argument("--seed", type=int, default=0, help="of the first run; the others follow")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="runs at the same time")
    parser.add_argument("--minutes", type=float, default=inf, help="after which no run begins")
    parser.add_argument("--save", type=Path, default=Path("out/campaigns"), help="folder for what is found")
    given = parser.parse_args(words)
    if given.name is None:
        _say("\n".join(f"{name:<18}{says}" for name, (says, _) in CAMPAIGNS.items()))
        return 0
    runs = given.runs or find(given.name).runs
    tally = execute(
        given.name, runs, given.seed, jobs=given.jobs, minutes=given.minutes, folder=given.save, tell=_say
    )
    _say(f"{given.name}: {tally}")
    return int(bool(tally.violations))


if __name__ == "__main__":
    sys.exit(main())
