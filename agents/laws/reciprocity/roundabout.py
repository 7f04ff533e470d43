"""A place where many are about to meet, and how each turns so that all go round it.

Robots that go straight on to one place stop each other there. If all go round it in one sense, one behind
the other, nobody has to wait, and a way that touches the circle is little longer than the straight one. The
circle on which disks that follow each other at an angle just touch has the radius of a disk over the sine of
half that angle.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, NamedTuple

from agents.laws.reciprocity.encounters import Encounter
from protocol.messages import Vector

WIDE: Final = 1.08  # times the circle on which the disks touch each other
LEAST: Final = 0.05  # rad from one to the next, which is some 120 on one circle
STEEPEST: Final = 0.5  # rad, by which a robot turns at most


class Roundabout(NamedTuple):
    """A circle that is left to the right."""

    x: float  # of its centre, m
    y: float
    radius: float  # m

    def turn(self, position: Vector, way: Vector, room: float = 1.0) -> float:
        """By how much (rad, to the left, not negative) `way` from a position is to be turned to touch a
        circle of `room` times the radius."""
        dx, dy = self.x - position[0], self.y - position[1]
        radius = room * self.radius
        aside = math.asin(radius / max(radius, math.hypot(dx, dy)))
        turn = math.atan2(dy, dx) + aside - math.atan2(way[1], way[0])
        return min(max(0.0, math.remainder(turn, 2.0 * math.pi)), STEEPEST)

    def is_ahead(self, position: Vector, way: Vector) -> bool:
        """Whether the centre is ahead of who is at a position and goes this way."""
        return (self.x - position[0]) * way[0] + (self.y - position[1]) * way[1] > 0.0


def together(encounters: Sequence[Encounter], within: float) -> list[Encounter]:
    """Those at most `within` seconds before or after the middle one."""
    if not encounters:
        return []
    middle = sorted([each.time for each in encounters])[len(encounters) // 2]
    return [each for each in encounters if abs(each.time - middle) <= within]


def roundabout(position: Vector, way: Vector, met: Sequence[Encounter]) -> Roundabout:
    """Where a robot meets others, and how much room all need there.

    Those whom it hears may be few of many: it takes the directions from which others come to be as dense
    as those that it knows.

    Args:
        position: own, m.
        way: velocity straight on, m/s.
        met: by whom; at least one.
    """
    ahead = math.fsum(each.time for each in met) / len(met)
    x, y = position[0] + ahead * way[0], position[1] + ahead * way[1]
    own = math.atan2(-way[1], -way[0])
    aside = [math.remainder(math.atan2(each.y - y, each.x - x) - own, 2.0 * math.pi) for each in met]
    between = (max(0.0, *aside) - min(0.0, *aside)) / len(met)
    radius = math.fsum(each.radius for each in met) / len(met)
    return Roundabout(x, y, WIDE * radius / math.sin(0.5 * max(between, LEAST)))
