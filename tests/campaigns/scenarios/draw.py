"""Random scenarios out of all that a scenario can express.

Lengths are drawn in workspaces of 1 cm to 200 m, times in ticks of 3 ms to 0.7 s, speeds in radii a
tick, so that what can happen does not depend on the units. Runs are short (`BUDGET`): what breaks a
protocol is an order of events, and that takes no more ticks than there are events.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, get_args

from deploy.library.instances import LARGEST_DENSITY
from deploy.library.load import resolved
from protocol.errors import ScenarioError
from protocol.scenario.body import PRESETS, Body, Preset
from protocol.scenario.file import document_of, parse_document, validated
from protocol.scenario.model import ADDITIONS, Control, Position, RobotSpec, Scenario, Time, Workspace
from tests.campaigns.campaign import Dice
from tests.campaigns.scenarios.disturbances import Scale, actuation, link, network, sensing
from tests.campaigns.scenarios.events import Fleet, orders, sensible, stories
from tests.campaigns.scenarios.places import around, by_points, drawn_together, loads, obstacles, scattered

BUDGET = (120.0, 3000.0)  # robots times ticks
TICKS = (6, 400)
_LAWS = ("gradient", "gradient", "gradient", "reciprocal", "Orca", "Barrier")
_ADVERSARY = "tests.laws.adversary:Adversary"
_ROBOTS = (1, *(4 * (2,)), *(4 * (3,)), *(3 * (4,)), 5, 5, 6, 7, 8)
_MANY = (10, 16)  # now and then
_FAR = (10.0, 1000.0, 9e4)  # m, from the origin to a room
_DENSITIES = (LARGEST_DENSITY, LARGEST_DENSITY, 0.25, 0.12)


def drawn(dice: Dice) -> Scenario | None:
    """A valid scenario with a number for k and the filter on.

    None if the disks find no room, or the scenario's own checks refuse it.
    """
    workspace = Workspace(dice.pick((0.3, 0.3, 2.0, dice.log_uniform(0.01, 200.0))))
    robots = _robots(dice, workspace.disk_radius)
    if robots is None:
        return None
    scale = _scale(dice, robots)
    control = _control(dice, scale, resolved(Scenario(robots, workspace=workspace)).k)
    body, robots = bodies(dice, scale, control.speed, robots)
    room = around(dice, workspace, robots)
    standing = obstacles(dice, robots, workspace.disk_radius, room.shape)
    parts, carrying = loads(dice, robots, standing, room.shape)
    faults = stories(dice, scale.robots, scale.ticks, scale.step)
    scenario = Scenario(
        robots,
        name="falsify",
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
        obstacles=standing,
        parts=parts,
        carrying=carrying,
        orders=orders(dice, scale, Fleet(robots, standing, room.shape), faults),
    )
    try:
        scenario = _elsewhere(dice, _with_guests_failing(dice, by_points(scenario), scale))
        if dice.chance(0.15):  # a law that wants a touch
            scenario = replace(scenario, control=replace(scenario.control, law=_ADVERSARY))
        return validated(scenario)
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
    """Equal or unequal, up to five to one, or now and then a thousand, m; together they fill 1 to 35 % of the
    workspace."""
    ratio = 1000.0 if dice.chance(0.03) else dice.pick((1.0, 1.0, 2.0, 5.0))
    parts = [dice.log_uniform(1.0, ratio) if ratio > 1.0 else 1.0 for _ in range(many)]
    density = dice.pick((*_DENSITIES, dice.log_uniform(0.01, LARGEST_DENSITY)))
    unit = workspace * (density / sum(part * part for part in parts)) ** 0.5
    return [unit * part for part in parts]


def _goals(
    dice: Dice, starts: Sequence[Position], radii: Sequence[float], workspace: float
) -> list[Position] | None:
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
    law = dice.pick(_LAWS)
    reach = scale.radius * dice.log_uniform(0.01, 3.0)  # m a tick
    control = Control(
        k=dice.pick((k, k, dice.log_uniform(0.3, 1e4))),
        speed=reach / scale.step,
        additions=tuple(each for each in ADDITIONS if dice.chance(0.8)),
    )
    return replace(control, law=_named(dice, scale, law))


def _named(dice: Dice, scale: Scale, law: str) -> str:
    """A law as the control table names it; the choices are as many for each law from outside."""
    if law == "gradient":
        return law
    own: dict[str, float | None] = {}
    if law == "Orca":
        own["horizon"] = dice.pick((None, scale.step * dice.log_uniform(0.5, 100.0)))
    if law == "Barrier":
        own["gain"] = dice.pick((None, dice.log_uniform(0.01, 2.0) / scale.step))
    own["noise"] = dice.pick((None, dice.uniform(0.0, 1.0)))
    own["margin"] = dice.pick((None, scale.radius * dice.uniform(0.0, 0.5)))
    if law == "reciprocal":
        return law
    arguments = ", ".join(f"{name}={value}" for name, value in own.items() if value is not None)
    return f"deploy.studies.peers.laws:{law}({arguments})"


_HEADINGS = (0.0, 0.0, 1.0, 3.2, -1.6)  # rad


def bodies(
    dice: Dice, scale: Scale, speed: float, robots: Sequence[RobotSpec]
) -> tuple[Preset | Body, tuple[RobotSpec, ...]]:
    """The body of a scenario, and its robots, some of which have bodies of their own.

    Args:
        speed: limit, m/s.
    """
    if dice.chance(0.5):
        return "point", tuple(robots)
    common: Preset | Body = one_body(dice, scale, speed)
    own = dice.pick((0.0, 0.0, 0.4))
    faced = []
    for robot in robots:
        body = one_body(dice, scale, speed) if dice.chance(own) else None
        faced.append(replace(robot, body=body, heading=dice.pick(_HEADINGS)))
    return common, tuple(faced)


def one_body(dice: Dice, scale: Scale, speed: float) -> Preset | Body:
    """A preset if all robots are large enough to be one, or a body that is made up."""
    fitting = [name for name in get_args(Preset) if _fits(name, scale)]
    if len(fitting) > 1 and dice.chance(0.5):
        preset: Preset = dice.pick(fitting)
        return preset
    offset = scale.radius * dice.log_uniform(0.02, 0.8)
    rim = speed * dice.log_uniform(0.2, 10.0)
    return Body(
        dice.pick(("point", "omnidirectional", "differential-drive", "differential-drive")),
        radius=dice.pick((None, scale.radius - offset)),
        offset=offset,
        track=scale.radius * dice.log_uniform(0.1, 2.0),
        speed=rim,
        acceleration=rim / scale.step * dice.pick((1e-2, dice.log_uniform(0.02, 10.0), 1.0)),
        hold=scale.step * dice.pick((0.0, 1.0, 2.0, dice.log_uniform(0.1, 30.0))),
        error=dice.pick((0.0, 0.0, 0.1, dice.uniform(0.0, 0.5))),
        lag=scale.step * dice.pick((0.0, dice.log_uniform(1e-3, 0.5))),
        play=scale.radius * dice.pick((0.0, dice.log_uniform(1e-6, 1e-2))),
        odometry=dice.pick((0.0, 0.1, dice.uniform(0.0, 0.5))),
        drift=scale.radius * dice.pick((0.0, dice.log_uniform(1e-6, 1e-2))),
    )


def _fits(name: Preset, scale: Scale) -> bool:
    disk = PRESETS[name].disk
    return disk is None or disk <= scale.radius


def shifted(scenario: Scenario, dx: float, dy: float) -> Scenario:
    """A scenario in a polygonal room, all of which is moved by (dx, dy), m."""

    def moved(value: Any, key: str = "") -> Any:
        if key in ("start", "goal", "center") and isinstance(value, list):
            return [value[0] + dx, value[1] + dy]
        if key == "points":
            return [[x + dx, y + dy] for x, y in value]
        if isinstance(value, dict):
            return {name: moved(each, name) for name, each in value.items()}
        return [moved(each) for each in value] if isinstance(value, list) else value

    return parse_document(moved(document_of(scenario)))
