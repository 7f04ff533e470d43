"""Where a law pulls: straight to the goal, or along the shortest way where things bar it."""

from __future__ import annotations

import math
from collections.abc import Sequence

from agents.navigation.route import Route, way_points
from protocol.geometry import Shape
from protocol.geometry.sphere_world import is_sphere_world

Vector = tuple[float, float]


class Attraction:
    """The pull on one robot.

    In a sphere world it is straight, as in Koditschek and Rimon's navigation functions; elsewhere gamma_i is
    the squared length of the shortest way, whose gradient leads to the first corner of it.

    Args:
        room: the workspace.
        radius: of the robot, m.
    """

    def __init__(self, room: Shape, radius: float) -> None:
        self._room, self._radius = room, radius
        self._things: list[Shape] = []
        self._route: Route | None = None

    def aim(self, position: Vector, goal: Vector, things: Sequence[Shape]) -> Vector:
        """The goal as it were if the shortest way to it were straight: ahead of `position`, as far, m."""
        if not things:
            return goal
        if self._things != list(things):
            self._begin(list(things))
        if self._route is None:
            return goal
        (x, y), length = self._route.ahead(position, goal)
        if (x, y) == goal:
            return goal
        dx, dy = x - position[0], y - position[1]
        scale = length / math.hypot(dx, dy)
        return position[0] + scale * dx, position[1] + scale * dy

    def _begin(self, things: list[Shape]) -> None:
        self._things = things
        self._route = None
        if not is_sphere_world(self._room, dict(enumerate(things, 1)), self._radius):
            self._route = Route(way_points(self._room, tuple(things), self._radius))
