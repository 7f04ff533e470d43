"""Random instances of robots that bring parts to their goals: how many end with all parts in place.

python -m tests.agents.movers.campaign --runs 200 [--first 0] [--parts 8] [--kill]

Counted are instances for which there is an order in which one part after another finds its way to its goal
(`agents.movers.order`). With `--kill` one robot dies for good as soon as it carries a part. That instance is
counted apart if, by where everything is at that instant and nothing else, the dead robot's disk lies on the
goal of a part, which can then never get there; or if the same search finds no order for the survivors, the
dead robot and its part standing there. Exit status 1 if anything touched.

To go on after some of the runs, give the seed that follows the last one as `--first`.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from agents.movers.places import Floor
from agents.movers.plan import Planner
from deploy.library.load import load
from deploy.run.local import LocalFleet
from deploy.theory.check.surrounded import surrounded
from protocol.geometry import Disk
from protocol.messages import Vector
from protocol.scenario.model import Scenario
from world.world import World

SECONDS = 300.0  # of simulated time
BARRED = "the dead robot lies on the goal of a part"
NO_ORDER = "no order found for the survivors"


@dataclass(frozen=True)
class Outcome:
    """What came of one instance."""

    seed: int
    left: tuple[int, ...]  # parts that are not in place
    verdict: str
    contacts: int
    clearance: float
    seconds: float
    apart: str  # why a death leaves no order, so that it is counted apart; "" if there is one


def run(scenario: Scenario, kill: bool = False) -> Outcome:
    """One instance; `kill`: a robot dies as soon as it carries a part."""
    fleet = LocalFleet([scenario])
    world, apart = fleet.world.world, ""
    before = _standing(world)
    while fleet.step() and _left(world):
        carriers = [each.carrier for each in world.coordinator.parts.places if each.carrier]
        if kill and carriers:
            fleet.kill(carriers[0])
            kill, apart = False, without_order(world, carriers[0], before)
        before = _standing(world)
    report = world.report()
    return Outcome(
        scenario.seed,
        _left(world),
        world.verdict,
        report["collisions"],
        report["min_clearance"],
        world.tick * scenario.time.step,
        apart,
    )


def without_order(world: World, dead: int, before: Mapping[int, Vector]) -> str:
    """Why survivors cannot bring all parts to their goals, one after another; "" if they can.

    Args:
        dead: a robot with a part, which stands where it is.
        before: where parts stood when it had not taken up its own, m.
    """
    scenario, places = world.scenario, world.simulation.places
    part = world.coordinator.parts.carried_by(dead)
    floor = Floor(
        {**before, part: places[dead]},
        (*(thing.shape for thing in scenario.things), Disk(*places[dead], scenario.spec(dead).radius)),
        {part: scenario.loaded_radius(dead, part)},
    )
    planner = Planner(scenario, min(each.radius for each in scenario.robots))
    if planner.barred(floor):
        return BARRED
    survivors = [places[robot] for robot in scenario.ids if robot != dead]
    return "" if planner.orders.exists(floor, survivors) else NO_ORDER


def _standing(world: World) -> dict[int, Vector]:
    """Where parts stand that nobody has, m."""
    known = world.coordinator.lives.things.standing
    places = world.coordinator.parts.places
    return {
        each.part: (known[each.thing].around.x, known[each.thing].around.y)
        for each in places
        if not each.carrier
    }


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
        print(_line(outcomes[-1]), flush=True)
    print(f"seeds {given.first} to {outcomes[-1].seed}")
    for apart in ("", BARRED, NO_ORDER):
        them = [each for each in outcomes if each.apart == apart]
        if them:
            said = f"counted apart, {apart}" if apart else "with an order"
            print(f"{said}: {sum(not each.left for each in them)} of {len(them)} with all parts in place")
    contacts = sum(each.contacts for each in outcomes)
    print(f"{contacts} contacts")
    return int(contacts > 0)


def _line(done: Outcome) -> str:
    told = f"parts {done.left} left, {done.verdict or 'stopped'}" if done.left else "all in place"
    return (
        f"seed {done.seed}: {told} after {done.seconds:.0f} s, {done.contacts} contacts, "
        f"clearance at least {1e6 * done.clearance:.3f} um" + (done.apart and f"; {done.apart}")
    )


if __name__ == "__main__":
    sys.exit(main())
