"""Static obstacles: how they repel, and where the goal pulls when they are in the way.

Disks enter beta as in a sphere world (Koditschek and Rimon, "Robot navigation functions on manifolds with
boundary", 1990): beta = |x - c|^2 - (rho + r)^2. Of a convex set in general, d(x) the distance from it,
beta = d^2 - rho^2. The gradient of d^2 is 2 (x - q), q the nearest point: that of a disk of radius 0 at q. So
is a straight wall of the room.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Final

from agents.law.route import Route, way_points
from agents.peers.state import Peer
from protocol.geometry import Disk, Shape, is_sphere_world
from protocol.messages import Vector

_TWO: Final = 2.0  # radii from each side of a passage: two of one size pass each other


def obstacle_disks(room: Shape, shapes: Iterable[Shape], x: float, y: float) -> list[Peer]:
    """All that stands as seen from (x, y), m; straight walls of the room included."""
    found: list[Peer] = []
    for shape in shapes:
        if isinstance(shape, Disk):
            found.append(Peer(shape.x, shape.y, shape.radius, 0.0))
        else:
            px, py = shape.nearest(x, y)
            found.append(Peer(px, py, 0.0, 0.0))
    if not isinstance(room, Disk):
        for nx, ny, offset in room.sides:
            away = offset - nx * x - ny * y
            found.append(Peer(x + away * nx, y + away * ny, 0.0, 0.0))
    return found


class Attraction:
    """The pull on one robot.

    In a sphere world it is straight, as in Koditschek and Rimon's navigation functions; elsewhere gamma_i is
    the squared length of the shortest way, whose gradient leads to the first corner of it.

    In a passage that is wide enough for one only, two that meet bar each other's way for good. So a robot
    that is not alone goes through those where two can pass, as long as they lead to its goal.

    Args:
        room: the workspace.
        radius: of the robot, m.
        alone: whether it is the only one.

    Attributes:
        winds: whether ways lead around things, as of the last `aim`.
        straight: how far the way that `aim` last found leads straight on, m; infinite where it does not turn.
    """

    def __init__(self, room: Shape, radius: float, alone: bool = False) -> None:
        self._room, self._radius = room, radius
        self._widths = ((1.0, False), (1.0, True)) if alone else ((_TWO, False), (1.0, False), (1.0, True))
        self._things: list[Shape] = []
        self._routes: list[Route] = []
        self._goal: Vector | None = None
        self._choice = 0  # of the routes, for this goal
        self.winds = False
        self.straight = math.inf

    @property
    def width(self) -> float:
        """Of the narrowest passages that the way found last may lead through, m."""
        return 2.0 * self._radius * (self._widths[self._choice][0] if self.winds else 1.0)

    def aim(self, position: Vector, goal: Vector, things: Sequence[Shape]) -> Vector:
        """The goal as it were if the shortest way to it were straight: ahead of `position`, as far, m."""
        self.straight = math.inf
        if not things:
            self._things, self.winds = [], False
            return goal
        if self._things != list(things):
            self._begin(list(things))
        if goal != self._goal:
            self._goal, self._choice = goal, 0
        found = self._ahead(position, goal) if self.winds else None
        if found is None or found[0] == goal:
            return goal
        (x, y), length = found
        dx, dy = x - position[0], y - position[1]
        self.straight = math.hypot(dx, dy)
        scale = length / self.straight
        return position[0] + scale * dx, position[1] + scale * dy

    def leads(self, start: Vector, goal: Vector, things: Sequence[Shape]) -> bool:
        """Whether a way from `start` to `goal` is known."""
        self.aim(start, goal, things)
        return not self.winds or self._ahead(start, goal) is not None

    def way(self, start: Vector, goal: Vector, things: Sequence[Shape]) -> list[Vector]:
        """Corners of the way that a robot is pulled along from `start`, the goal last, m."""
        if not (self.leads(start, goal, things) and self.winds):
            return [goal]
        corners = [start]
        while corners[-1] != goal:
            found = self._ahead(corners[-1], goal)
            corners.append(goal if found is None else found[0])
        return corners[1:]

    def _ahead(self, position: Vector, goal: Vector) -> tuple[Vector, float] | None:
        """By the widest passages that lead there; once narrow ones are needed, by these for this goal.

        A robot that chose anew in every place could go to and fro between two ways for ever.
        """
        for choice in range(self._choice, len(self._widths)):
            found = self._route(choice).ahead(position, goal)
            if found is not None:
                self._choice = choice
                return found
        return None

    def _begin(self, things: list[Shape]) -> None:
        self._things, self._routes, self._choice = things, [], 0
        self.winds = not is_sphere_world(self._room, dict(enumerate(things, 1)), self._radius)

    def _route(self, choice: int) -> Route:
        """Ways through passages of one width; looked for once they are needed."""
        while len(self._routes) <= choice:
            width, narrow = self._widths[len(self._routes)]
            self._routes.append(
                Route(way_points(self._room, tuple(self._things), width * self._radius, narrow))
            )
        return self._routes[choice]
