"""Whom a robot would touch if it went straight on and each of the others as it goes.

Those near are heard in every tick. Of those far off the world's summaries say once a second where they are,
and so how they go on.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple, final

import numpy as np

from agents.laws.view import View
from agents.peers.far import FarPicture
from protocol.messages import Vector

NEARLY: Final = 2.0  # distances of contact: who passes as near may be met before the next summary


class Encounter(NamedTuple):
    """With a peer that this robot would touch, going straight on."""

    x: float  # where it is, m
    y: float
    radius: float  # m
    time: float  # until they are closest, s


class Course(NamedTuple):
    """Of a peer that is too far off to be heard."""

    robot: int
    x: float  # where it was, m
    y: float
    vx: float  # m/s
    vy: float
    radius: float  # m


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
        self._far: list[Course] = []

    def met(self, view: View, way: Vector) -> list[Encounter]:
        """All of them, if the robot goes `way` (m/s)."""
        found: list[Encounter] = []
        for state in view.neighbours.moving():
            if state.placed:
                self._meet(found, view, way, state.tick, state.x, state.y, state.vx, state.vy, state.radius)
        picture = view.neighbours.picture
        if picture is None:
            return found
        if picture is not self._picture:
            self._picture, self._far = picture, self._crossing(picture, view, way)
        neighbours = view.neighbours
        for each in self._far:
            if neighbours.state(each.robot) is None and each.robot not in neighbours.standing:
                self._meet(found, view, way, picture.tick, each.x, each.y, each.vx, each.vy, each.radius)
        return found

    def _meet(
        self,
        found: list[Encounter],
        view: View,
        way: Vector,
        tick: int,
        x: float,
        y: float,
        vx: float,
        vy: float,
        radius: float,
    ) -> None:
        """Take up a peer that was at (x, y) in `tick`, and goes on since, if it would be touched."""
        age = (view.tick - tick) * self._period
        x, y = x + age * vx, y + age * vy
        rx, ry = x - view.position[0], y - view.position[1]
        ux, uy = way[0] - vx, way[1] - vy
        square = ux * ux + uy * uy
        time = (rx * ux + ry * uy) / square if square > 0.0 else 0.0
        time = min(max(time, 0.0), self._ahead)
        if math.hypot(rx - time * ux, ry - time * uy) < self._radius + radius:
            found.append(Encounter(x, y, radius, time))

    def _crossing(self, picture: FarPicture, view: View, way: Vector) -> list[Course]:
        """Of all whom a summary has, those who may be met before the next one."""
        x, y, dx, dy, radii = picture.courses()
        age = view.tick - picture.tick
        rx, ry = x + age * dx - view.position[0], y + age * dy - view.position[1]
        vx, vy = dx / self._period, dy / self._period
        ux, uy = way[0] - vx, way[1] - vy
        square = ux * ux + uy * uy
        time = (rx * ux + ry * uy) / np.where(square > 0.0, square, 1.0)
        time = np.clip(time, 0.0, self._ahead)
        rx -= time * ux
        ry -= time * uy
        reach = NEARLY * (self._radius + radii)
        indices: list[int] = np.flatnonzero(rx * rx + ry * ry < reach * reach).tolist()
        robots = picture.said.robots
        return [
            Course(robots.item(i), x.item(i), y.item(i), vx.item(i), vy.item(i), radii.item(i))
            for i in indices
            if robots.item(i) != self._robot
        ]
