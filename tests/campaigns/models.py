"""Campaigns over models and fleets that are beside the tests of what they search."""

from functools import cache, partial
from random import Random
from types import ModuleType

from protocol.scenario.body import PRESETS
from tests.agents.bodies.test_rides import KINDS, ROUNDING, excess_of
from tests.agents.lines.models.product import Product
from tests.agents.lines.models.skirmishes import aftermath, skirmish
from tests.campaigns.campaign import Campaign, Dice, Outcome
from tests.world.plants.fleet import BODIES as CARRIERS
from tests.world.plants.fleet import PERIODS, drive, hostile
from tests.world.shell import test_world_dies as worlds

_product = cache(Product)


def _of_lines(model: ModuleType, dice: Dice) -> Outcome:
    violation = model.violation_of(dice.seed, _product())
    return Outcome("violated" if violation else "held", violation)


def _ride(dice: Dice) -> Outcome:
    """One ride of one of the bodies, which take turns."""
    seed = dice.seed
    kind = KINDS[seed % len(KINDS)]
    excess = excess_of(seed // len(KINDS), kind, _product())
    violation = f"{kind}: beyond by {excess:.3g} m" if excess > ROUNDING else ""
    return Outcome(kind, violation, figures={"excess, m": excess})


def _attack(plant: str, dice: Dice) -> Outcome:
    """A fleet whose law wants a touch; bodies and periods take turns."""
    names = [name for name in CARRIERS if plant == "integrator" or isinstance(CARRIERS[name], str)]
    name = names[dice.seed % len(names)]
    period = PERIODS[dice.seed // len(names) % len(PERIODS)]
    setting = hostile(name, period, plant, dice.seed)
    report = drive(setting)
    touches = report["min_clearance"] < 0.0 or bool(report.get("plant", {}).get("contacts"))
    figures = {"ticks": float(report["ticks"] * setting.robots), "smallest gap, m": report["min_clearance"]}
    return Outcome(f"{name}, {period:g} s", f"touch: {setting}" if touches else "", figures=figures)


def _deviation(dice: Dice) -> Outcome:
    from tests.world.plants.deviations import PERIODS as MEASURED
    from tests.world.plants.deviations import WHEELED, lacking

    name = WHEELED[dice.seed % len(WHEELED)]
    period = MEASURED[dice.seed // len(WHEELED) % len(MEASURED)]
    play, drift = lacking(PRESETS[name], period, 500, dice.seed)
    violation = f"lacks play {play:.3g} m, drift {drift:.3g} m" if max(play, drift) > 0.0 else ""
    return Outcome(f"{name}, {period:g} s", violation, figures={"play, m": play, "drift, m": drift})


def _deaths(dice: Dice) -> Outcome:
    """A course whose world dies at any operation by which it tells what it did."""
    name = dice.pick(sorted(worlds.COURSES))
    doom, report = worlds.died(name, Random(dice.seed))
    worlds.check(name, doom, report)
    return Outcome(name, figures={"deaths": float(doom.deaths)})


SKIRMISH = Campaign(partial(_of_lines, skirmish), 5_000)
AFTERMATH = Campaign(partial(_of_lines, aftermath), 5_000)
BODIES = Campaign(_ride, 30_000)
DEVIATIONS = Campaign(_deviation, 40, patience=600.0)
WORLDS = Campaign(_deaths, 1_000)
ADVERSARY = Campaign(partial(_attack, "integrator"), 4_000)
ADVERSARY_MUJOCO = Campaign(partial(_attack, "mujoco"), 300, patience=600.0)
