"""A scenario out of all that a scenario can express, drawn from a seed and a number alone.

Lengths are drawn in workspaces of 1 cm to 200 m, times in ticks of 3 ms to 0.7 s, speeds in radii a
tick, so that what can happen does not depend on the units. Runs are short (`BUDGET`): what breaks a
protocol is an order of events, and that takes no more ticks than there are events.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import count
from typing import Literal

from deploy.library.load import resolved
from deploy.studies.falsify.scenarios.bodies import bodies
from deploy.studies.falsify.scenarios.dice import Dice
from deploy.studies.falsify.scenarios.disturbances import Scale, actuation, link, network, sensing
from deploy.studies.falsify.scenarios.errands import Fleet, orders
from deploy.studies.falsify.scenarios.lives import sensible, stories
from deploy.studies.falsify.scenarios.loads import by_points, loads
from deploy.studies.falsify.scenarios.places import drawn_together, scattered
from deploy.studies.falsify.scenarios.shifted import shifted
from deploy.studies.falsify.scenarios.surroundings import around, things
from protocol.errors import ScenarioError
from protocol.scenario.file import validated
from protocol.scenario.model import Control, Point, RobotSpec, Scenario, Time, Workspace

BUDGET = (120.0, 3000.0)  # robots times ticks
TICKS = (6, 400)
LAWS: tuple[Literal["gradient", "reciprocal", "orca", "barrier"], ...] = (
    *("gradient", "gradient", "gradient"),
    *("reciprocal", "orca", "barrier"),
)
_ROBOTS = (1, *(4 * (2,)), *(4 * (3,)), *(3 * (4,)), 5, 5, 6, 7, 8)
_MANY = (10, 16)  # now and then
_FAR = (10.0, 1000.0, 9e4)  # m, from the origin to a room
_DENSITIES = (0.4, 0.35, 0.25, 0.12)
_STREAM = 1


def drawn(seed: int, number: int) -> tuple[Scenario, int]:
    """Scenario `number` of the campaign with this seed, and how many draws were refused before it.

    It is valid, k is a number, and the filter is on. Refused is what disks find no room in, or what the
    scenario's own checks do not accept.
    """
    dice = Dice(seed, number, _STREAM)
    for refused in count():
        scenario = _attempt(dice, f"falsify-{seed}-{number}")
        if scenario is not None:
            return scenario, refused
    raise AssertionError


def _attempt(dice: Dice, name: str) -> Scenario | None:
    workspace = Workspace(dice.pick((0.3, 0.3, 2.0, dice.log_uniform(0.01, 200.0))))
    robots = _robots(dice, workspace.disk_radius)
    if robots is None:
        return None
    scale = _scale(dice, robots)
    control = _control(dice, scale, resolved(Scenario(robots, workspace=workspace)).k)
    body, robots = bodies(dice, scale, control.speed, robots)
    room = around(dice, workspace, robots)
    standing = things(dice, robots, workspace.disk_radius, room.shape)
    parts, carrying = loads(dice, robots, standing, room.shape)
    faults = stories(dice, scale.robots, scale.ticks, scale.step)
    scenario = Scenario(
        robots,
        name=name,
        seed=dice.whole(0, 2**31),
        workspace=room,
        time=_time(dice, scale),
        control=control,
        sensing=sensing(dice, scale),
        link=link(dice, scale),
        process=faults,
        actuation=actuation(dice),
        body=body,
        network=network(dice, scale),
        things=standing,
        parts=parts,
        carrying=carrying,
        orders=orders(dice, scale, Fleet(robots, standing, room.shape), faults),
    )
    try:
        return validated(_elsewhere(dice, _with_guests_failing(dice, by_points(scenario), scale)))
    except ScenarioError:
        return None


def _with_guests_failing(dice: Dice, scenario: Scenario, scale: Scale) -> Scenario:
    """Process faults of robots that come later, in some scenarios."""
    guests = [spec.id for spec in scenario.newcomers if spec.id not in scenario.ids]
    if not guests or not dice.chance(0.3):
        return scenario
    more = stories(dice, guests, scale.ticks, scale.step)
    return replace(scenario, process=sensible((*scenario.process, *more)))


def _elsewhere(dice: Dice, scenario: Scenario) -> Scenario:
    """A polygonal room and all that is in it, at times far from the origin."""
    if scenario.workspace.points is None or not dice.chance(0.3):
        return scenario
    far, angle = dice.pick(_FAR), dice.uniform(0.0, math.tau)
    return shifted(scenario, far * math.cos(angle), far * math.sin(angle))


def _robots(dice: Dice, workspace: float) -> tuple[RobotSpec, ...] | None:
    """Disks, starts and goals; None if they found no room."""
    many = dice.whole(*_MANY) if dice.chance(0.02) else dice.pick(_ROBOTS)
    radii = _radii(dice, many, workspace)
    starts = scattered(dice, radii, workspace)
    goals = None if starts is None else _goals(dice, starts, radii, workspace)
    if starts is None or goals is None:
        return None
    near = dice.pick((0, 0, many, 3 * many))
    starts = drawn_together(dice, starts, radii, workspace, near)
    goals = drawn_together(dice, goals, radii, workspace, dice.pick((0, near)))
    ids = list(range(1, many + 1))
    if dice.chance(0.1):  # ids with gaps
        ids = sorted(dice.shuffled(range(1, 3 * many + 1))[:many])
    return tuple(map(RobotSpec, ids, radii, starts, goals))


def _radii(dice: Dice, many: int, workspace: float) -> list[float]:
    """Equal or unequal, up to five to one, or now and then a thousand, m; together they fill 1 to 40 % of the
    workspace."""
    ratio = 1000.0 if dice.chance(0.03) else dice.pick((1.0, 1.0, 2.0, 5.0))
    parts = [dice.log_uniform(1.0, ratio) if ratio > 1.0 else 1.0 for _ in range(many)]
    density = dice.pick((*_DENSITIES, dice.log_uniform(0.01, 0.4)))
    unit = workspace * (density / sum(part * part for part in parts)) ** 0.5
    return [unit * part for part in parts]


def _goals(
    dice: Dice, starts: Sequence[Point], radii: Sequence[float], workspace: float
) -> list[Point] | None:
    """Anywhere; opposite of the start; where it is; or where others of the same size begin."""
    kind = dice.pick(("anywhere", "anywhere", "opposite", "opposite", "here", "swapped"))
    if kind == "opposite":
        return [(-x, -y) for x, y in starts]
    if kind == "here":
        return list(starts)
    if kind == "swapped" and len(set(radii)) == 1:
        return dice.shuffled(starts)
    return scattered(dice, radii, workspace)


def _scale(dice: Dice, robots: Sequence[RobotSpec]) -> Scale:
    low, high = TICKS
    ticks = min(max(low, round(dice.log_uniform(*BUDGET) / len(robots))), high)
    step = dice.pick((0.05, 0.05, dice.log_uniform(0.003, 0.7)))
    return Scale(ticks, step, min(spec.radius for spec in robots), tuple(spec.id for spec in robots))


def _time(dice: Dice, scale: Scale) -> Time:
    """Fences from one tick to longer than the run; deadlocks after the run, or soon."""
    fence = dice.pick((1.0, dice.log_uniform(1.0, 10.0), dice.log_uniform(1.0, 2.0 * scale.ticks)))
    deadlock = dice.pick((2.0, 2.0, 2.0, dice.log_uniform(0.02, 1.0))) * scale.ticks
    return Time(
        step=scale.step,
        limit=scale.ticks * scale.step,
        tolerance=scale.radius * dice.log_uniform(1e-3, 0.3),
        fence=fence * scale.step,
        deadlock=max(1.0, deadlock) * scale.step,
    )


def _control(dice: Dice, scale: Scale, k: float) -> Control:
    law = dice.pick(LAWS)
    reach = scale.radius * dice.log_uniform(0.01, 3.0)  # m a tick
    return Control(
        law=law,
        k=dice.pick((k, k, dice.log_uniform(0.3, 1e4))),
        pace=dice.pick(("common", "own")),
        speed=reach / scale.step,
        escape=dice.chance(0.8),
        horizon=dice.pick((None, scale.step * dice.log_uniform(0.5, 100.0))) if law == "orca" else None,
        barrier_gain=dice.pick((None, dice.log_uniform(0.01, 2.0) / scale.step))
        if law == "barrier"
        else None,
        symmetry_noise=None if law == "gradient" else dice.pick((None, dice.uniform(0.0, 1.0))),
        margin=None if law == "gradient" else dice.pick((None, scale.radius * dice.uniform(0.0, 0.5))),
    )
