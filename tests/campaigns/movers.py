"""Random instances of robots that carry parts to their goals: how many end with all parts in place.

Counted are instances for which there is an order in which one part after another finds its way to its goal
(`agents.parts.planner`). With `kill` one robot dies for good as soon as it carries a part. That instance is
counted apart if, by where everything is at that instant and nothing else, the dead robot's disk lies on the
goal of a part, which can then never get there; or if the same search finds no order for the survivors, the
dead robot and its part standing there.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

from agents.parts.grid import Layout
from agents.parts.planner import Planner
from deploy.library.load import load
from deploy.run.local import LocalFleet
from deploy.theory.surrounded import surrounded
from protocol.geometry import Disk
from protocol.messages import Vector
from protocol.scenario.model import Scenario
from tests.campaigns.campaign import Campaign, Dice, Outcome
from world.report import result_of
from world.world import WorldCore

SECONDS = 300.0  # of simulated time
PARTS = 8
_TRIES = 100  # instances, one of which surely has an order
BARRED = "the dead robot lies on the goal of a part"
NO_ORDER = "no order found for the survivors"


@dataclass(frozen=True)
class Ended:
    seed: int
    left: tuple[int, ...]  # parts that are not in place
    verdict: str
    contacts: int
    clearance: float
    seconds: float
    apart: str  # why a death leaves no order, so that it is counted apart; "" if there is one


def run(scenario: Scenario, kill: bool = False) -> Ended:
    """One instance; `kill`: a robot dies as soon as it carries a part."""
    fleet = LocalFleet(scenario)
    world, apart = fleet.world.world, ""
    before = _standing(world)
    while fleet.step() and _left(world):
        carriers = [each.carrier for each in world.parts.places if each.carrier]
        if kill and carriers:
            fleet.kill(carriers[0])
            kill, apart = False, without_order(world, carriers[0], before)
        before = _standing(world)
    report = result_of(world)
    return Ended(
        scenario.seed,
        _left(world),
        world.verdict,
        report["collisions"],
        report["min_clearance"],
        world.tick * scenario.time.step,
        apart,
    )


def without_order(world: WorldCore, dead: int, before: Mapping[int, Vector]) -> str:
    """Why survivors cannot bring all parts to their goals, one after another; "" if they can.

    Args:
        dead: a robot with a part, which stands where it is.
        before: where parts stood when it had not taken up its own, m.
    """
    scenario, places = world.scenario, world.simulation.places
    part = world.parts.carried_by(dead)
    layout = Layout(
        {**before, part: places[dead]},
        (
            *(obstacle.shape for obstacle in scenario.obstacles),
            Disk(*places[dead], scenario.spec(dead).radius),
        ),
        {part: scenario.loaded_radius(dead, part)},
    )
    planner = Planner(scenario, min(each.radius for each in scenario.robots))
    if any(shape.distance(*each.goal) < each.radius for each in scenario.parts for shape in layout.others):
        return BARRED
    survivors = [places[robot] for robot in scenario.ids if robot != dead]
    return "" if planner.orders.exists(layout, survivors) else NO_ORDER


def _standing(world: WorldCore) -> dict[int, Vector]:
    """Where the parts are that no robot carries, m."""
    known = world.lives.obstacles.standing
    places = world.parts.places
    return {
        each.part: (known[each.obstacle].around.x, known[each.obstacle].around.y)
        for each in places
        if not each.carrier
    }


def _left(world: WorldCore) -> tuple[int, ...]:
    parts = world.parts
    return tuple(each.part for each in parts.places if not parts.in_place(each.part))


def instance(seed: int) -> Scenario:
    """The first instance that has an order, of those that are drawn from a seed."""
    seeds = (seed * _TRIES + number for number in range(_TRIES))
    drawn = (load(f"parts-{PARTS}", [f"time.limit={SECONDS}"], each) for each in seeds)
    return next(scenario for scenario in drawn if surrounded(scenario).order)


def _outcome(dice: Dice, kill: bool = False) -> Outcome:
    """Whether all parts get in place; the violations are contacts."""
    ended = run(instance(dice.seed), kill)
    said = ended.apart or ("all in place" if not ended.left else f"left, {ended.verdict or 'stopped'}")
    violation = f"{ended.contacts} contacts in parts-{PARTS} of seed {ended.seed}" if ended.contacts else ""
    return Outcome(said, violation, figures={"clearance, m": ended.clearance, "parts left": len(ended.left)})


MOVERS = Campaign(_outcome, 200)
KILL = Campaign(partial(_outcome, kill=True), 200)
