"""A scenario to run before another one on the same robots: short, and it leaves a mess."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from deploy.studies.falsify.scenarios.dice import Dice
from deploy.studies.falsify.scenarios.disturbances import Scale, link, sensing
from deploy.studies.falsify.scenarios.errands import Fleet, orders
from deploy.studies.falsify.scenarios.lives import Event, sensible, stories
from deploy.studies.falsify.scenarios.loads import by_points, loads
from deploy.studies.falsify.scenarios.mutate import scale_of
from protocol.errors import ScenarioError
from protocol.scenario.file import validated
from protocol.scenario.model import Order, ProcessFault, Scenario

_STREAM = 4
_ATTEMPTS = 50
_ENDS: tuple[Event, ...] = ("kill", "pause", "pause", "restart")


def preceding(scenario: Scenario, number: int) -> Scenario:
    """What is run before `scenario`: of robots with its ids, in its workspace, over in the middle.

    It is drawn from the scenario's seed and `number`. Robots are killed, paused and restarted up to its last
    tick, or removed, and there are robots that come under ids under which others come in `scenario`.
    """
    dice = Dice(scenario.seed, number, _STREAM)
    for _ in range(_ATTEMPTS):
        try:
            return validated(_attempt(dice, scenario))
        except ScenarioError:
            continue
    return replace(scenario, name=f"{scenario.name}-first")


def _attempt(dice: Dice, scenario: Scenario) -> Scenario:
    ticks = dice.whole(1, max(8, scale_of(scenario).ticks // 2))
    scale = replace(scale_of(scenario), ticks=ticks)
    room = scenario.workspace.shape
    fleet = Fleet(scenario.robots, scenario.things, room)
    own = (*stories(dice, scale.robots, ticks, scale.step), *_at_the_end(dice, scale))
    asked = (*orders(dice, scale, fleet, own, some=0.7), *_guests(dice, scenario, scale))
    guests = sorted({order.add.id for order in asked if order.add is not None} - {*scale.robots})
    theirs = stories(dice, guests, ticks, scale.step) if guests and dice.chance(0.5) else ()
    first = replace(
        scenario,
        name=f"{scenario.name}-first",
        seed=dice.whole(0, 2**31),
        time=replace(scenario.time, limit=ticks * scale.step),
        process=sensible((*own, *theirs)),
        orders=tuple(sorted((*asked, *_leaving(dice, scale)), key=lambda order: order.at)),
    )
    if dice.chance(0.5):
        first = replace(first, link=link(dice, scale), sensing=sensing(dice, scale))
    if dice.chance(0.5):
        parts, carrying = loads(dice, scenario.robots, scenario.things, room, some=0.7)
        first = by_points(replace(first, parts=parts, carrying=carrying))
    return first


def _at_the_end(dice: Dice, scale: Scale) -> Iterator[ProcessFault]:
    """What happens to some robots in the last ticks."""
    for robot in scale.robots:
        if dice.chance(0.4):
            yield ProcessFault(robot, _late(dice, scale), dice.pick(_ENDS))


def _leaving(dice: Dice, scale: Scale) -> Iterator[Order]:
    """Robots that are removed in the last ticks."""
    if dice.chance(0.3):
        yield Order(_late(dice, scale), remove=dice.pick(scale.robots))


def _guests(dice: Dice, scenario: Scenario, scale: Scale) -> Iterator[Order]:
    """Robots that come in `scenario` come here, too, at other times."""
    for order in scenario.orders:
        if order.add is not None and dice.chance(0.6):
            yield replace(order, at=dice.whole(0, scale.ticks - 1) * scale.step)


def _late(dice: Dice, scale: Scale) -> float:
    return max(0, scale.ticks - dice.whole(1, 3)) * scale.step
