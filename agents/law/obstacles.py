"""Static obstacles: their repulsion, and the attraction around them.

Disks enter beta as in a sphere world (Koditschek and Rimon, "Robot navigation functions on manifolds with
boundary", 1990): beta = |x - c|^2 - (rho + r)^2. Of a convex set, or a straight wall, at the distance d(x),
beta = d^2 - rho^2. The gradient of d^2 is 2 (x - q), q the nearest point: that of a disk of radius 0 at q.

Attraction straight to the goal has a minimum behind a straight face that is turned away from the goal,
whatever k: the face curves less than the circle around the goal. So where obstacles are not the disks of a
sphere world, the distance to the goal is taken along the shortest path (`agents.law.distance_field`).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Final

from agents.law.distance_field import MANY, Clearances, FieldRoute, clearances
from agents.law.passages import gaps
from agents.peers.state import Peer
from protocol.geometry import Disk, Shape, is_sphere_world
from protocol.messages import Vector

# Of a path, in radii: the clearance that it keeps; and half the width of gaps that are closed, if it may use
# all others. The first is for passages in which two robots can pass, as narrow as the grid may show them.
_WIDTHS: Final = ((1.75, None), (1.0, None), (1.0, 1.02), (1.0, 1.0))
_DETOUR: Final = 1.25  # lengths of the path through narrower passages, up to which the first is used
_CLEAR: Final = 2  # number of these that need no gaps: very many obstacles have too many


def obstacle_disks(room: Shape, shapes: Iterable[Shape], x: float, y: float) -> list[Peer]:
    """Obstacles as disks seen from (x, y), m, with the straight walls of the room."""
    found: list[Peer] = []
    for shape in shapes:
        if isinstance(shape, Disk):
            found.append(Peer(shape.x, shape.y, shape.radius, 0.0))
        else:
            px, py = shape.nearest(x, y)
            found.append(Peer(px, py, 0.0, 0.0))
    if not isinstance(room, Disk):
        for nx, ny, offset in room.sides:
            distance = offset - nx * x - ny * y
            found.append(Peer(x + distance * nx, y + distance * ny, 0.0, 0.0))
    return found


class Attraction:
    """The pull on one robot of `radius`, m.

    In a sphere world it is straight, as in Koditschek and Rimon's navigation functions; elsewhere gamma_i is
    the squared length of the shortest path, whose gradient leads to its first corner.

    Two robots that meet in a passage with room for one block each other. So unless a robot is alone, it uses
    passages in which two can pass, if these lead to its goal without a long detour.
    """

    def __init__(self, room: Shape, radius: float, alone: bool = False) -> None:
        self._room, self._radius = room, radius
        self._first = 1 if alone else 0
        self._obstacles: tuple[Shape, ...] = ()
        self._routes: dict[int, FieldRoute] = {}  # by index of the width, prepared when first needed
        self._clearances: Clearances | None = None
        self._goal: Vector | None = None
        self._choice = self._first  # index of the route for this goal
        self.winds = False  # whether paths lead around obstacles, as of the last `aim`
        # Length of the straight first part of the path of the last `aim`, m; infinite if it does not turn.
        self.straight = math.inf

    @property
    def width(self) -> float:
        """Width of the narrowest passages that the last path may use, m."""
        return 2.0 * self._radius * (_WIDTHS[self._choice][0] if self.winds else 1.0)

    def aim(self, position: Vector, goal: Vector, obstacles: Sequence[Shape]) -> Vector:
        """Point of attraction, m: as far as the goal along the path, straight ahead of `position`."""
        self.straight = math.inf
        if not obstacles:
            self._obstacles, self.winds = (), False
            return goal
        self._follow(obstacles)
        if goal != self._goal:
            self._goal, self._choice = goal, self._first
            self._choose(position, goal)
        found = self._ahead(position, goal) if self.winds else None
        if found is None or found[0] == goal:
            return goal
        (x, y), length = found
        dx, dy = x - position[0], y - position[1]
        self.straight = math.hypot(dx, dy)
        scale = length / self.straight
        return position[0] + scale * dx, position[1] + scale * dy

    def repelling(self, position: Vector, obstacles: Sequence[Shape]) -> list[Peer]:
        """Repelling obstacles at `position` (m), as disks; of very many only near ones."""
        self._follow(obstacles)
        x, y = position
        near = self._map.near(x, y) if len(obstacles) > MANY else obstacles
        return obstacle_disks(self._room, near, x, y)

    def leads(self, start: Vector, goal: Vector, obstacles: Sequence[Shape]) -> bool:
        """Whether a path from `start` to `goal` was found."""
        self.aim(start, goal, obstacles)
        return not self.winds or self._ahead(start, goal) is not None

    def way(self, start: Vector, goal: Vector, obstacles: Sequence[Shape]) -> list[Vector]:
        """Corners of the path from `start`, ending with the goal, m."""
        if not (self.leads(start, goal, obstacles) and self.winds):
            return [goal]
        corners = [start]
        while corners[-1] != goal:
            found = self._ahead(corners[-1], goal)
            corners.append(goal if found is None else found[0])
        return corners[1:]

    def _choose(self, position: Vector, goal: Vector) -> None:
        """For a new goal, use narrow passages where wide ones are a long detour."""
        if not self.winds or self._choice > 0:
            return
        wide, narrow = (self._route(choice).ahead(position, goal) for choice in (0, 1))
        if wide is None or (narrow is not None and wide[1] > _DETOUR * narrow[1]):
            self._choice = 1

    def _ahead(self, position: Vector, goal: Vector) -> tuple[Vector, float] | None:
        """Path through the widest possible passages. Once narrow ones are needed, they remain in use for this
        goal, so that no robot alternates between two paths for ever.
        """
        count = len(_WIDTHS) if len(self._obstacles) <= MANY else _CLEAR
        for choice in range(self._choice, count):
            found = self._route(choice).ahead(position, goal)
            if found is not None:
                self._choice = choice
                return found
        return None

    def _follow(self, obstacles: Sequence[Shape]) -> None:
        obstacles = tuple(obstacles)  # an unchanged tuple is the same object, which saves a comparison
        if obstacles is self._obstacles:
            return
        known, self._obstacles = self._obstacles, obstacles
        if obstacles == known:
            return
        self._routes, self._goal = {}, None
        self._clearances = None
        self.winds = not is_sphere_world(self._room, dict(enumerate(obstacles, 1)), self._radius)

    @property
    def _map(self) -> Clearances:
        if self._clearances is None:
            self._clearances = clearances(self._room, self._obstacles, self._radius)
        return self._clearances

    def _route(self, choice: int) -> FieldRoute:
        """Paths through passages of one width."""
        route = self._routes.get(choice)
        if route is None:
            clear, closed = _WIDTHS[choice]
            below = None if closed is None else gaps(self._room, self._obstacles, 2.0 * closed * self._radius)
            route = self._routes[choice] = FieldRoute(self._map, clear * self._radius, below)
        return route
