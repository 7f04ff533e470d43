"""What carries the robots: points in half of the scenarios, else presets, or bodies in units of the run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import get_args

from deploy.studies.falsify.scenarios.dice import Dice
from deploy.studies.falsify.scenarios.disturbances import Scale
from protocol.scenario.body import PRESETS, Body, Preset
from protocol.scenario.model import RobotSpec

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
