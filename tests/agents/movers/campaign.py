"""Random instances of robots that bring parts to their goals: how many end with all parts in place.

python -m tests.agents.movers.campaign --runs 200 [--first 0] [--parts 8] [--kill]

Counted are instances for which an order exists in which one part after another finds its way; with `--kill`
one robot dies for good as soon as it carries a part, and those are left out in which it then stands where a
part is to be. Exit status 1 if anything touched.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass

from deploy.library.load import load
from deploy.run.local import LocalFleet
from deploy.theory.check.surrounded import surrounded
from protocol.scenario.model import Scenario
from world.world import World

SECONDS = 300.0  # of simulated time


@dataclass(frozen=True)
class Outcome:
    """What came of one instance."""

    seed: int
    left: tuple[int, ...]  # parts that are not in place
    verdict: str
    contacts: int
    clearance: float
    seconds: float
    barred: bool  # by a robot that stands where a part is to be


def run(scenario: Scenario, kill: bool = False) -> Outcome:
    """One instance; `kill`: a robot dies as soon as it carries a part."""
    fleet = LocalFleet([scenario])
    world = fleet.world.world
    while fleet.step() and _left(world):
        carriers = [each.carrier for each in world.coordinator.part_places if each.carrier]
        if kill and carriers:
            fleet.kill(carriers[0])
            kill = False
    report = world.report()
    seconds = world.tick * scenario.time.step
    return Outcome(
        scenario.seed,
        _left(world),
        world.verdict,
        report["collisions"],
        report["min_clearance"],
        seconds,
        bool(_left(world)) and _is_barred(world),
    )


def _is_barred(world: World) -> bool:
    dead = [each for each in world.coordinator.roster.members if each.status == "standing"]
    return any(
        each.position is not None and math.dist(each.position, part.goal) < each.radius + part.radius
        for each in dead
        for part in world.scenario.parts
    )


def _left(world: World) -> tuple[int, ...]:
    parts = world.coordinator.parts
    return tuple(each.part for each in parts.places if not parts.in_place(each.part))


def instances(first: int, count: int, parts: int) -> Iterator[Scenario]:
    """Random instances that have an order, from a seed on."""
    seed = first
    while count:
        scenario = load(f"parts-{parts}", [f"time.limit={SECONDS}"], seed)
        seed += 1
        if surrounded(scenario).order:
            count -= 1
            yield scenario


def main() -> int:
    """Run a campaign; exit status 1 if anything touched."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--first", type=int, default=0, help="seed")
    parser.add_argument("--parts", type=int, default=8)
    parser.add_argument("--kill", action="store_true")
    given = parser.parse_args()
    outcomes = []
    for scenario in instances(given.first, given.runs, given.parts):
        outcomes.append(run(scenario, given.kill))
        done = outcomes[-1]
        told = f"parts {done.left} left, {done.verdict or 'stopped'}" if done.left else "all in place"
        print(
            f"seed {done.seed}: {told} after {done.seconds:.0f} s, {done.contacts} contacts, "
            f"clearance at least {1e6 * done.clearance:.3f} um",
            flush=True,
        )
    possible = [each for each in outcomes if not each.barred]
    whole = sum(not each.left for each in possible)
    contacts = sum(each.contacts for each in outcomes)
    left_out = len(outcomes) - len(possible)
    print(f"{whole} of {len(possible)} with all parts in place, {contacts} contacts; {left_out} left out")
    return int(contacts > 0)


if __name__ == "__main__":
    sys.exit(main())
