"""Random instances of robots that carry parts to their goals: how many end with all parts in place.

Counted are instances for which there is an order in which one part after another finds its way to its goal
(`agents.parts.planner`).
"""

from dataclasses import dataclass

from deploy.library.load import load
from deploy.run.local import LocalFleet
from deploy.theory.surrounded import surrounded
from protocol.scenario.model import Scenario
from tests.campaigns.campaign import Campaign, Dice, Outcome
from world.report import result_of
from world.world import WorldCore

SECONDS = 300.0  # of simulated time
PARTS = 8
_TRIES = 100  # instances, one of which surely has an order


@dataclass(frozen=True)
class Ended:
    left: tuple[int, ...]  # parts that are not in place
    verdict: str
    contacts: int
    clearance: float


def run(scenario: Scenario, kill: bool = False) -> Ended:
    """One instance; `kill`: a robot dies for good as soon as it carries a part."""
    fleet = LocalFleet(scenario)
    world = fleet.world.world
    while fleet.step() and _left(world):
        carriers = [each.carrier for each in world.parts.places if each.carrier]
        if kill and carriers:
            fleet.kill(carriers[0])
            kill = False
    report = result_of(world)
    return Ended(_left(world), world.verdict, report["collisions"], report["min_clearance"])


def _left(world: WorldCore) -> tuple[int, ...]:
    parts = world.parts
    return tuple(each.part for each in parts.places if not parts.in_place(each.part))


def instance(seed: int) -> Scenario:
    """The first instance that has an order, of those that are drawn from a seed."""
    seeds = (seed * _TRIES + number for number in range(_TRIES))
    drawn = (load(f"parts-{PARTS}", [f"time.limit={SECONDS}"], each) for each in seeds)
    return next(scenario for scenario in drawn if surrounded(scenario).order)


def _outcome(dice: Dice) -> Outcome:
    """Whether all parts get in place; the violations are contacts."""
    scenario = instance(dice.seed)
    ended = run(scenario)
    said = f"left, {ended.verdict or 'stopped'}" if ended.left else "all in place"
    touches = f"{ended.contacts} contacts in parts-{PARTS} of seed {scenario.seed}"
    figures = {"clearance, m": ended.clearance, "parts left": len(ended.left)}
    return Outcome(said, touches if ended.contacts else "", figures=figures)


MOVERS = Campaign(_outcome, 200)
