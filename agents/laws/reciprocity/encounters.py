"""Whom a robot would touch if it went straight on and each of the others as it goes.

Those near are heard in every tick. Of those far off the world sums up now and then where they are; from one
summary to the next it shows how they go on, as a State would say.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple, final

import numpy as np

from agents.laws.view import View
from agents.peers.far import FarPicture
from agents.peers.state import PeerState
from protocol.messages import Vector

NEARLY: Final = 2.0  # distances of contact: who passes as near may be met before the next summary


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
        self._far: list[PeerState] = []  # who may be met of those who are not heard

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
        """Of all whom a summary has, those who may be met before the next one, as if they had said so."""
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
            robot: int = picture.said.robots.item(row)
            if robot != self._robot:
                place, velocity = (x.item(row), y.item(row)), (vx.item(row), vy.item(row))
                radius: float = radii.item(row)
                found.append(
                    PeerState(robot, 0, picture.tick, True, *place, 0.0, 0.0, 0.0, *velocity, radius=radius)
                )
        return found
