"""A place where many are about to meet, and how each turns so that all go round it.

If all go round it in one sense, one behind the other, none has to wait, and a way that touches the circle is
little longer than the straight one. The circle on which disks that follow each other at an angle just touch
has the radius of a disk over the sine of half that angle.

Near peers send a State every tick; two summaries show the courses of far ones.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, NamedTuple, final

import numpy as np

from agents.law.api import View
from agents.peers.far import FarPicture
from agents.peers.state import PeerState
from protocol.messages import Vector

WIDE: Final = 1.08  # times the circle on which the disks touch each other
LEAST: Final = 0.05  # rad from one to the next, which is some 120 on one circle
STEEPEST: Final = 0.5  # rad, by which a robot turns at most
NEARLY: Final = 2.0  # distances of contact: a peer that passes as near may be met before the next summary


class Encounter(NamedTuple):
    """With a peer that this robot would touch, going straight on."""

    x: float  # where it is, m
    y: float
    radius: float  # m
    time: float  # until they are closest, s


@final
class Encounters:
    """One robot's.

    Args:
        robot: own id.
        radius: own, m.
        period: of a tick, s.
        ahead: how far, s.
    """

    def __init__(self, robot: int, radius: float, period: float, ahead: float) -> None:
        self._robot, self._radius, self._period, self._ahead = robot, radius, period, ahead
        self._picture: FarPicture | None = None
        self._far: list[PeerState] = []  # those that may be met and send no State

    def met(self, view: View, way: Vector) -> list[Encounter]:
        """All of them, if the robot goes `way` (m/s)."""
        found: list[Encounter] = []
        neighbours, picture = view.neighbours, view.neighbours.picture
        for state in neighbours.moving():
            if state.placed:
                self._meet(found, view, way, state)
        if picture is not None and picture is not self._picture:
            self._picture, self._far = picture, self._crossing(picture, view, way)
        for state in self._far:
            if neighbours.state(state.robot) is None and state.robot not in neighbours.standing:
                self._meet(found, view, way, state)
        return found

    def _meet(self, found: list[Encounter], view: View, way: Vector, state: PeerState) -> None:
        """Take up a peer that goes on since its State, if it would be touched."""
        age = (view.tick - state.tick) * self._period
        x, y = state.x + age * state.vx, state.y + age * state.vy
        rx, ry = x - view.position[0], y - view.position[1]
        ux, uy = way[0] - state.vx, way[1] - state.vy
        square = ux * ux + uy * uy
        time = (rx * ux + ry * uy) / square if square > 0.0 else 0.0
        time = min(max(time, 0.0), self._ahead)
        if math.hypot(rx - time * ux, ry - time * uy) < self._radius + state.radius:
            found.append(Encounter(x, y, state.radius, time))

    def _crossing(self, picture: FarPicture, view: View, way: Vector) -> list[PeerState]:
        """Of all in a summary, those that may be met before the next one, as if by their States."""
        x, y, dx, dy, radii = picture.courses()
        age = view.tick - picture.tick
        vx, vy = dx / self._period, dy / self._period
        rx, ry = x + age * dx - view.position[0], y + age * dy - view.position[1]
        ux, uy = way[0] - vx, way[1] - vy
        square = ux * ux + uy * uy
        time = np.clip((rx * ux + ry * uy) / np.where(square > 0.0, square, 1.0), 0.0, self._ahead)
        rx -= time * ux
        ry -= time * uy
        reach = NEARLY * (self._radius + radii)
        found: list[PeerState] = []
        for row in np.flatnonzero(rx * rx + ry * ry < reach * reach).tolist():
            robot: int = picture.places.robots.item(row)
            if robot != self._robot:
                place, velocity = (x.item(row), y.item(row)), (vx.item(row), vy.item(row))
                radius: float = radii.item(row)
                found.append(
                    PeerState(robot, 0, picture.tick, True, *place, 0.0, 0.0, 0.0, *velocity, radius=radius)
                )
        return found


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
        """Whether the centre is ahead of a robot at a position that goes this way."""
        return (self.x - position[0]) * way[0] + (self.y - position[1]) * way[1] > 0.0


def together(encounters: Sequence[Encounter], within: float) -> list[Encounter]:
    """Those at most `within` seconds before or after the middle one."""
    if not encounters:
        return []
    middle = sorted([each.time for each in encounters])[len(encounters) // 2]
    return [each for each in encounters if abs(each.time - middle) <= within]


def roundabout(position: Vector, way: Vector, met: Sequence[Encounter]) -> Roundabout:
    """Where a robot meets others, and how much room all need there.

    The peers that it hears may be few of many: the directions from which others come are taken to be as dense
    as the known ones.

    Args:
        way: velocity straight on, m/s.
        met: at least one.
    """
    ahead = math.fsum(each.time for each in met) / len(met)
    x, y = position[0] + ahead * way[0], position[1] + ahead * way[1]
    own = math.atan2(-way[1], -way[0])
    aside = [math.remainder(math.atan2(each.y - y, each.x - x) - own, 2.0 * math.pi) for each in met]
    between = (max(0.0, *aside) - min(0.0, *aside)) / len(met)
    radius = math.fsum(each.radius for each in met) / len(met)
    return Roundabout(x, y, WIDE * radius / math.sin(0.5 * max(between, LEAST)))
