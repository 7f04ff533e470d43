"""Roundabouts: a place where many are about to meet, round which all go in one sense.

Then no robot has to wait, and a path tangent to the circle is little longer than the straight one. Disks that
follow each other at an angle just touch on a circle with the radius of a disk over the sine of half that
angle.

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

WIDE: Final = 1.08  # radius over that of the circle on which the disks touch
LEAST: Final = 0.05  # rad, smallest angle between neighbours: some 120 on one circle
STEEPEST: Final = 0.5  # rad, largest rotation of the direction
NEARLY: Final = 2.0  # contact distances within which a far peer may be met before the next summary


class Encounter(NamedTuple):
    """Predicted contact with a peer, if the robot goes straight on."""

    x: float  # present position of the peer, m
    y: float
    radius: float  # m
    time: float  # to the closest approach, s


@final
class Encounters:
    """Those of one robot with an id and a radius, m, up to `ahead` seconds; `period`: of a tick, s."""

    def __init__(self, robot: int, radius: float, period: float, ahead: float) -> None:
        self._robot, self._radius, self._period, self._ahead = robot, radius, period, ahead
        self._picture: FarPicture | None = None
        self._far: list[PeerState] = []  # peers that may be met, but send no States

    def met(self, view: View, way: Vector) -> list[Encounter]:
        """All encounters, if the robot moves with the velocity `way` (m/s)."""
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
        """Peers in a summary that may be met before the next one, as if by their States."""
        (x, y, dx, dy, radii), tick = picture.courses(), picture.places.tick
        age = view.tick - tick
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
                found.append(PeerState(robot, 0, tick, True, *place, 0.0, 0.0, 0.0, *velocity, radius=radius))
        return found


class Roundabout(NamedTuple):
    """A circle that robots keep to their right."""

    x: float  # of its centre, m
    y: float
    radius: float  # m

    def turn(self, position: Vector, way: Vector, room: float = 1.0) -> float:
        """Angle (rad, left, >= 0) that turns `way` onto a tangent of a circle of `room` times the radius."""
        dx, dy = self.x - position[0], self.y - position[1]
        radius = room * self.radius
        aside = math.asin(radius / max(radius, math.hypot(dx, dy)))
        turn = math.atan2(dy, dx) + aside - math.atan2(way[1], way[0])
        return min(max(0.0, math.remainder(turn, 2.0 * math.pi)), STEEPEST)

    def is_ahead(self, position: Vector, way: Vector) -> bool:
        """Whether the centre is ahead of a robot at `position` that moves `way`."""
        return (self.x - position[0]) * way[0] + (self.y - position[1]) * way[1] > 0.0


def together(encounters: Sequence[Encounter], within: float) -> list[Encounter]:
    """Encounters within `within` seconds of their median."""
    if not encounters:
        return []
    middle = sorted([each.time for each in encounters])[len(encounters) // 2]
    return [each for each in encounters if abs(each.time - middle) <= within]


def roundabout(position: Vector, way: Vector, met: Sequence[Encounter]) -> Roundabout:
    """The roundabout for at least one encounter, with room for all; `way`: velocity straight on, m/s.

    Only few of many peers may be known: unknown ones are assumed to come from as densely spaced directions.
    """
    ahead = math.fsum(each.time for each in met) / len(met)
    x, y = position[0] + ahead * way[0], position[1] + ahead * way[1]
    own = math.atan2(-way[1], -way[0])
    aside = [math.remainder(math.atan2(each.y - y, each.x - x) - own, 2.0 * math.pi) for each in met]
    between = (max(0.0, *aside) - min(0.0, *aside)) / len(met)
    radius = math.fsum(each.radius for each in met) / len(met)
    return Roundabout(x, y, WIDE * radius / math.sin(0.5 * max(between, LEAST)))
