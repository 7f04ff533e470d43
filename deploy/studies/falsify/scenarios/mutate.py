"""Small changes to a scenario that came near to touching: one to three features, the rest as it was."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from deploy.studies.falsify.scenarios.bodies import bodies, one_body
from deploy.studies.falsify.scenarios.dice import Dice
from deploy.studies.falsify.scenarios.disturbances import (
    Scale,
    actuation,
    link,
    network,
    one_sensing,
    partition,
    sensing,
    span,
)
from deploy.studies.falsify.scenarios.draw import LAWS, TICKS
from deploy.studies.falsify.scenarios.errands import Fleet, orders
from deploy.studies.falsify.scenarios.lives import moment, sensible, stories
from deploy.studies.falsify.scenarios.loads import by_points, loads
from deploy.studies.falsify.scenarios.places import drawn_together, fits
from deploy.studies.falsify.shrinking.simpler import forget
from protocol.errors import ScenarioError
from protocol.scenario.file import document_of, parse_document, validated
from protocol.scenario.model import Point, Scenario

Change = Callable[[Dice, Scenario, Scenario], Scenario]

_STREAM = 2
_ATTEMPTS = 50


def mutated(parent: Scenario, other: Scenario, seed: int, number: int) -> tuple[Scenario, int]:
    """Mutant `number` of a campaign, and how many were refused before it.

    Args:
        parent: what is changed.
        other: what traits are taken over from, at times.
    """
    dice = Dice(seed, number, _STREAM)
    for refused in range(_ATTEMPTS):
        child = parent
        try:
            for _ in range(dice.whole(1, 3)):
                child = dice.pick(CHANGES)(dice, child, other)
            return validated(by_points(replace(child, name=f"falsify-{seed}-{number}"))), refused
        except ScenarioError:
            continue
    return replace(parent, name=f"falsify-{seed}-{number}", seed=dice.whole(0, 2**31)), _ATTEMPTS


def scale_of(scenario: Scenario) -> Scale:
    """The units of a scenario's run."""
    ticks = min(max(TICKS[0], scenario.ticks(scenario.time.limit)), TICKS[1])
    smallest = min(spec.radius for spec in scenario.robots)
    return Scale(ticks, scenario.time.step, smallest, scenario.ids)


# -- lives


def _shift_fault(dice: Dice, scenario: Scenario, _: Scenario) -> Scenario:
    """Another time for one fault: a little earlier or later, or near another event."""
    if not scenario.process:
        return _more_faults(dice, scenario, scenario)
    faults, scale = list(scenario.process), scale_of(scenario)
    place = dice.whole(0, len(faults) - 1)
    near = round(faults[place].at / scale.step) + dice.whole(-3, 3)
    tick = max(0, near) if dice.chance(0.5) else moment(dice, scale.ticks, scale.step, faults)
    faults[place] = replace(faults[place], at=tick * scale.step)
    return replace(scenario, process=sensible(faults))


def _other_robot(dice: Dice, scenario: Scenario, _: Scenario) -> Scenario:
    """The same for another robot."""
    one, other = dice.pick(scenario.ids), dice.pick(scenario.ids)
    swap = {one: other, other: one}
    faults = [replace(fault, robot=swap.get(fault.robot, fault.robot)) for fault in scenario.process]
    return replace(scenario, process=sensible(faults))


def _more_faults(dice: Dice, scenario: Scenario, _: Scenario) -> Scenario:
    scale = scale_of(scenario)
    more = stories(dice, scenario.ids, scale.ticks, scale.step)
    return replace(scenario, process=sensible((*scenario.process, *more)))


def _fewer_faults(dice: Dice, scenario: Scenario, _: Scenario) -> Scenario:
    kept = [fault for fault in scenario.process if dice.chance(0.7)]
    return replace(scenario, process=sensible(kept))


# -- orders


def _more_orders(dice: Dice, scenario: Scenario, _: Scenario) -> Scenario:
    fleet = Fleet(scenario.robots, scenario.things, scenario.workspace.shape)
    more = orders(dice, scale_of(scenario), fleet, scenario.process, 1.0)
    return replace(scenario, orders=tuple(sorted((*scenario.orders, *more), key=lambda order: order.at)))


def _fewer_orders(dice: Dice, scenario: Scenario, _: Scenario) -> Scenario:
    return replace(scenario, orders=tuple(order for order in scenario.orders if dice.chance(0.5)))


def _shift_order(dice: Dice, scenario: Scenario, _: Scenario) -> Scenario:
    """Another time for one order: a little earlier or later, or with another event."""
    if not scenario.orders:
        return _more_orders(dice, scenario, scenario)
    asked, step = list(scenario.orders), scenario.time.step
    place = dice.whole(0, len(asked) - 1)
    times = [asked[place].at, *(fault.at for fault in scenario.process), *(order.at for order in asked)]
    at = max(0, round(dice.pick(times) / step) + dice.whole(-3, 3)) * step
    asked[place] = replace(asked[place], at=at)
    return replace(scenario, orders=tuple(sorted(asked, key=lambda order: order.at)))


# -- bodies


def _other_bodies(dice: Dice, scenario: Scenario, _: Scenario) -> Scenario:
    """Other bodies for all, or for one."""
    scale, speed = scale_of(scenario), scenario.control.speed
    if dice.chance(0.5) or scenario.body == "point":
        body, robots = bodies(dice, scale, speed, scenario.robots)
        return replace(scenario, body=body, robots=robots)
    place, robots = dice.whole(0, len(scenario.robots) - 1), scenario.robots
    one = replace(robots[place], body=one_body(dice, scale, speed))
    return replace(scenario, robots=(*robots[:place], one, *robots[place + 1 :]))


# -- parts


def _other_parts(dice: Dice, scenario: Scenario, _: Scenario) -> Scenario:
    """Parts drawn again, or none."""
    room = scenario.workspace.shape
    parts, carrying = loads(dice, scenario.robots, scenario.things, room, some=0.8)
    return replace(scenario, parts=parts, carrying=carrying)


# -- network and sensors


def _other_link(dice: Dice, scenario: Scenario, _: Scenario) -> Scenario:
    """One trait of the link drawn again."""
    scale, fresh = scale_of(scenario), link(dice, scale_of(scenario))
    links = scenario.link
    return replace(
        scenario,
        link=dice.pick(
            (
                fresh,
                replace(links, delay=fresh.delay),
                replace(links, delay=span(dice, scale, dice.whole(0, 30))),
                replace(links, jitter=fresh.jitter),
                replace(links, loss=fresh.loss),
                replace(links, loss=0.0, duplicate=0.0),
                replace(links, duplicate=fresh.duplicate),
                replace(links, partition=(*links.partition, partition(dice, scale))[-5:]),
                replace(links, partition=links.partition[1:]),
            )
        ),
    )


def _other_network(dice: Dice, scenario: Scenario, _: Scenario) -> Scenario:
    return replace(scenario, network=network(dice, scale_of(scenario)))


def _other_sensing(dice: Dice, scenario: Scenario, _: Scenario) -> Scenario:
    """All drawn again, or one entry, or its noise at another size and its bias in another direction."""
    scale, entries = scale_of(scenario), list(scenario.sensing)
    place = dice.whole(0, len(entries) - 1)
    old = entries[place]
    factor, angle = dice.log_uniform(0.3, 3.0), dice.uniform(-math.pi, math.pi)
    bias = factor * math.hypot(*old.bias)
    scaled = replace(
        old,
        noise_bound=None if old.noise_bound is None else factor * old.noise_bound,
        noise=old.noise * dice.log_uniform(0.3, 3.0),
        bias=(bias * math.cos(angle), bias * math.sin(angle)),
    )
    entries[place] = dice.pick(
        (one_sensing(dice, scale, old.robots), scaled, scaled, replace(old, dropout=dice.uniform(0.0, 1.0)))
    )
    return replace(scenario, sensing=sensing(dice, scale) if dice.chance(0.2) else tuple(entries))


def _other_actuation(dice: Dice, scenario: Scenario, _: Scenario) -> Scenario:
    return replace(scenario, actuation=actuation(dice))


# -- robots


def _moved(dice: Dice, scenario: Scenario, _: Scenario) -> Scenario:
    """Starts or goals closer together, at the wall, a little aside, or exchanged for the others."""
    radii, wall = [spec.radius for spec in scenario.robots], scenario.workspace.shape.around.radius
    starts = [spec.start for spec in scenario.robots]
    goals = [spec.goal for spec in scenario.robots]
    match dice.whole(0, 3):
        case 0:
            starts = drawn_together(dice, starts, radii, wall, dice.whole(1, 3))
        case 1:
            goals = drawn_together(dice, goals, radii, wall, dice.whole(1, 3))
        case 2:
            starts, goals = goals, starts
        case _:
            for points in (starts, goals):
                _nudged(dice, points, radii, wall)
    return replace(
        scenario,
        robots=tuple(
            replace(spec, start=start, goal=goal)
            for spec, start, goal in zip(scenario.robots, starts, goals, strict=True)
        ),
    )


def _nudged(dice: Dice, points: list[Point], radii: list[float], wall: float) -> None:
    """Move one of the points by up to its radius if there is room, in place."""
    i = dice.whole(0, len(points) - 1)
    x, y = before = points[i]
    size = radii[i] * dice.log_uniform(1e-3, 1.0)
    points[i] = x + dice.uniform(-size, size), y + dice.uniform(-size, size)
    if not fits(i, points, radii, wall):
        points[i] = before


def _without_one(dice: Dice, scenario: Scenario, _: Scenario) -> Scenario:
    return scenario if len(scenario.robots) == 1 else without(scenario, dice.pick(scenario.ids))


def without(scenario: Scenario, robot: int) -> Scenario:
    """The same without one robot and all that is said of it; raises ScenarioError if it cannot be."""
    document = document_of(scenario)
    forget(robot, document)
    return parse_document(document, scenario.name)


# -- time, law, chance


def _other_pace(dice: Dice, scenario: Scenario, _: Scenario) -> Scenario:
    """Another law, speed, fence or end."""
    time, control = scenario.time, scenario.control
    step = time.step
    scale = scale_of(scenario)
    longest = max(TICKS[0], min(TICKS[1], round(1.5 * scale.ticks))) * step
    return dice.pick(
        (
            replace(scenario, control=replace(control, speed=control.speed * dice.log_uniform(0.3, 3.0))),
            replace(scenario, control=replace(control, pace="own" if control.pace == "common" else "common")),
            replace(scenario, control=replace(control, k=control_k(scenario) * dice.log_uniform(0.1, 10.0))),
            replace(
                scenario,
                control=replace(control, law=dice.pick(LAWS), horizon=None, barrier_gain=None, margin=None),
            ),
            replace(scenario, time=replace(time, fence=step * dice.log_uniform(1.0, 50.0))),
            replace(scenario, time=replace(time, limit=longest)),
        )
    )


def control_k(scenario: Scenario) -> float:
    """k, which is a number in every scenario of a campaign, within what a mutant may multiply."""
    return min(max(scenario.k, 1e-3), 1e6)


def _other_chance(dice: Dice, scenario: Scenario, _: Scenario) -> Scenario:
    """Other noise, losses and delays of the same kind."""
    return replace(scenario, seed=dice.whole(0, 2**31))


def _crossed(dice: Dice, scenario: Scenario, other: Scenario) -> Scenario:
    """Faults, or what the network or the motors do, as in another scenario; its robots taken for these."""
    ids = dict(zip(other.ids, scenario.ids, strict=False))
    ratio = scenario.time.step / other.time.step
    faults = [
        replace(fault, robot=ids[fault.robot], at=fault.at * ratio)
        for fault in other.process
        if fault.robot in ids
    ]
    if dice.chance(0.7):
        return replace(scenario, process=sensible(faults))
    return replace(scenario, actuation=other.actuation, seed=other.seed)


CHANGES: tuple[Change, ...] = (
    *(_shift_fault, _shift_fault, _shift_fault, _other_robot, _more_faults, _fewer_faults),
    *(_shift_order, _shift_order, _shift_order, _more_orders, _fewer_orders, _other_bodies, _other_parts),
    *(_other_link, _other_link, _other_sensing, _other_sensing, _other_actuation, _other_network),
    *(_moved, _moved, _without_one, _other_pace, _other_chance, _other_chance, _crossed),
)
