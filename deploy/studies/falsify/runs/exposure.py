"""Exposure: how far two robots were from being behind a line that keeps them apart, while one of them moved.

The guarantee rests on an invariant (`agents.lines.ends`): a robot that moves has, for every other one, a
line or a tangent that it is behind and the other one beyond. Where that fails nothing need touch yet; it
only takes another wish, or another moment.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from protocol.messages import Line, Truth, Vector
from protocol.scenario.model import Scenario

Sides = tuple[int, int, tuple[Line, ...]]  # tick, robot, and the lines that it keeps to then

_NOTHING = 100.0  # what having no line at all counts for, in what a robot moves in a tick


def exposure(scenario: Scenario, truths: Sequence[Truth], sides: Sequence[Sides]) -> float:
    """The worst of all pairs and ticks, in what a robot moves in a tick; at most 0 if the invariant held."""
    radii: dict[int, float] = {}
    for spec in (*scenario.robots, *scenario.newcomers):
        radii[spec.id] = min(spec.radius, radii.get(spec.id, math.inf))
    reach = scenario.control.speed * scenario.time.step
    where = [dict(zip(truth.robots, truth.positions, strict=True)) for truth in truths]
    worst = -math.inf
    for tick, robot, lines in sides:
        if tick + 1 >= len(where) or where[tick].get(robot) in (None, where[tick + 1].get(robot)):
            continue
        there = where[tick].keys() & where[tick + 1].keys()
        if robot not in there:
            continue
        kept: dict[int, float] = {}
        own = where[tick + 1][robot], radii[robot]
        for peer, nx, ny, limit in lines:
            if peer not in there:
                continue
            beyond = limit - min(_along(nx, ny, where[t][peer]) for t in (tick, tick + 1)) + radii[peer]
            excess = max(beyond, _along(nx, ny, own[0]) + own[1] - limit)
            kept[peer] = min(excess, kept.get(peer, math.inf))
        known = kept.keys() if scenario.hears_near else there  # of far ones nothing is said
        excesses = [kept.get(peer, _NOTHING * reach) for peer in known if peer != robot]
        worst = max(worst, *excesses, -math.inf)
    return worst / reach


def _along(nx: float, ny: float, point: Vector) -> float:
    return nx * point[0] + ny * point[1]
