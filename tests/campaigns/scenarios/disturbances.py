"""What goes wrong with sensors, links and motors: from nothing to extremes, in the units of the run."""

import math
from dataclasses import dataclass

from protocol.scenario.body import Actuation, Span
from protocol.scenario.model import Sensing
from protocol.scenario.network import Link, Network, Partition
from tests.campaigns.campaign import Dice
from tests.campaigns.scenarios.places import polar


@dataclass(frozen=True)
class Scale:
    """Length of a run, ticks; of a tick, s; radius of the smallest robot, m; ids of the robots."""

    ticks: int
    step: float
    radius: float
    robots: tuple[int, ...]


def actuation(dice: Dice) -> Actuation:
    """Exact in most runs."""
    return Actuation(dice.pick((0.0, 0.0, 0.0, 0.02, dice.uniform(0.0, 0.3), 0.3)))


def sensing(dice: Dice, scale: Scale) -> tuple[Sensing, ...]:
    """Ideal, the same for all, or one kind for all and others for some."""
    if dice.chance(0.35):
        return (Sensing(),)
    entries = [one_sensing(dice, scale)]
    for _ in range(dice.pick((0, 0, 1, 2))):
        some = dice.shuffled(scale.robots)[: dice.whole(1, len(scale.robots))]
        entries.append(one_sensing(dice, scale, tuple(sorted(some))))
    return tuple(entries)


def one_sensing(dice: Dice, scale: Scale, robots: tuple[int, ...] | None = None) -> Sensing:
    """Noise and bias up to the size of a robot; late and missing measurements."""
    bound = dice.pick((0.0, *(scale.radius * dice.log_uniform(1e-3, 1.0) for _ in range(3))))
    bias = dice.pick((0.0, 0.0, scale.radius * dice.log_uniform(1e-4, 0.5)))
    return Sensing(
        delay=span(dice, scale, dice.pick((0, 0, 1, 3, scale.ticks // 4))),
        noise=bound * dice.log_uniform(0.1, 5.0),
        noise_bound=bound if bound or dice.chance(0.5) else None,
        bias=polar((0.0, 0.0), bias, dice.uniform(-math.pi, math.pi)),
        dropout=dice.pick((0.0, 0.0, 0.1, dice.uniform(0.0, 1.0))),
        robots=robots,
        heading=dice.pick((0.0, 0.0, dice.log_uniform(1e-4, 0.5))),
        contradiction=dice.pick(("stand", "stand", "newest")),
    )


def link(dice: Dice, scale: Scale) -> Link:
    """Late, lost, repeated and reordered States, and several partitions at a time."""
    if dice.chance(0.1):
        return Link()
    return Link(
        delay=span(dice, scale, dice.pick((0, 1, 2, 5, 20, scale.ticks // 2, scale.ticks))),
        jitter=dice.pick((0.0, 0.0, 0.0, scale.step * dice.log_uniform(0.1, scale.ticks))),
        loss=dice.pick((0.0, 0.0, dice.uniform(0.0, 0.7), dice.uniform(0.7, 1.0))),
        duplicate=dice.pick((0.0, 0.0, dice.uniform(0.0, 1.0))),
        partition=tuple(partition(dice, scale) for _ in range(dice.pick((0, 0, 0, 1, 2, 4)))),
    )


def network(dice: Dice, scale: Scale) -> Network:
    """Which peers a robot receives States from: all in most runs, near ones only in others."""
    if dice.chance(0.7):
        return Network()
    return Network("near", dice.pick((None, scale.radius * dice.log_uniform(0.01, 30.0))))


def partition(dice: Dice, scale: Scale) -> Partition:
    """One to three groups without links between them; a robot in none has no link at all."""
    begin = dice.pick((0, dice.whole(0, scale.ticks)))
    end = begin + dice.whole(1, max(1, scale.ticks // 2))
    groups: list[list[int]] = [[] for _ in range(dice.whole(1, 3))]
    for robot in scale.robots:
        if dice.chance(0.85):
            dice.pick(groups).append(robot)
    return Partition(begin * scale.step, end * scale.step, tuple(tuple(group) for group in groups if group))


def span(dice: Dice, scale: Scale, most: int) -> Span:
    """A delay of up to so many ticks, fixed or random, and not always whole ticks."""
    high = scale.step * most * dice.pick((1.0, dice.uniform(0.0, 1.0)))
    delays: tuple[Span, ...] = (high, (0.0, high), (high * dice.uniform(0.0, 1.0), high))
    return dice.pick(delays)
