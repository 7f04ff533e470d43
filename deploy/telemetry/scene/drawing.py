"""What a fleet looks like in Foxglove's 3D panel: from where everything is to entities of a scene."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import cache
from itertools import pairwise

from deploy.telemetry.scene.foxglove import (
    Color,
    Cylinder,
    Entity,
    Line,
    LineType,
    Pose,
    Text,
    Time,
    Triangles,
    Vector,
)
from protocol import messages
from protocol.geometry import Shape
from protocol.scenario.model import Scenario

WORLD = "world"  # the frame in which positions are told
_DIGITS = 5  # of a metre
_NEAR = 3  # radii of gap; between robots farther apart no line is drawn
_HUES = ("0072b2", "d98e00", "009e73", "c0629a", "46a6dd", "8a6f3e")
_GREY, _RED, _DARK = "7a828c", "c5161d", "1c1f23"


def frame(robot: int) -> str:
    """The frame that moves with a robot."""
    return f"robot_{robot}"


class Moment:
    """Where robots were at one time; drawn once, however often a trail shows it.

    Attributes:
        places: m, by robot.
    """

    __slots__ = ("_points", "places")

    def __init__(self, places: dict[int, messages.Vector]) -> None:
        self.places = places
        self._points: dict[int, Vector] = {}

    @property
    def points(self) -> dict[int, Vector]:
        """The same as points of lines."""
        if not self._points:
            self._points = {robot: _point(x, y) for robot, (x, y) in self.places.items()}
        return self._points

    def forget(self, robot: int) -> None:
        """Leave a robot out."""
        self.places.pop(robot, None)
        self._points.pop(robot, None)


class Drawing:
    """How the robots of one run are drawn. All methods take the time of what they draw first."""

    def __init__(self, scenario: Scenario, radii: Mapping[int, float]) -> None:
        """`radii`: m, of everybody who is drawn; others may be added later."""
        self._scenario, self._radii = scenario, radii
        self._ranks = {robot: rank for rank, robot in enumerate(scenario.ids)}

    def room(self, stamp: Time, shapes: Collection[Shape]) -> Entity:
        """The boundary, and what stands."""
        edges = [_loop(self._scenario.workspace.shape.outline(), _GREY)]
        edges += [_loop(shape.outline(), _GREY) for shape in shapes]
        solid = tuple(_fan(shape.outline(), _color(_GREY, 0.3)) for shape in shapes)
        return Entity(stamp, WORLD, "room", lines=tuple(edges), triangles=solid)

    def robot(self, stamp: Time, robot: int, *, down: bool) -> Entity:
        """One robot, in its own frame."""
        radius = self._radii[robot]
        height = radius / 2
        color = _color(_RED) if down else self._hue(robot)
        disk = _disk((0.0, 0.0), radius, height, color)
        label = Text(Pose(Vector(z=1.5 * height)), 0.8 * radius, _color(_DARK), str(robot))
        return Entity(stamp, frame(robot), f"robot {robot}", cylinders=(disk,), texts=(label,))

    def goals(self, stamp: Time, goals: Mapping[int, messages.Vector]) -> Entity:
        """Where robots go, m."""
        disks = tuple(
            _disk(goal, radius := self._radii[robot], radius / 50, self._hue(robot, 0.3))
            for robot, goal in goals.items()
        )
        return Entity(stamp, WORLD, "goals", cylinders=disks)

    def trails(self, stamp: Time, moments: Sequence[Moment], robots: Iterable[int]) -> Entity:
        """Where robots came along."""
        passed = [moment.points for moment in moments]
        lines = tuple(
            Line(LineType.STRIP, points, self._hue(robot, 0.6))
            for robot in robots
            if len(points := tuple(each[robot] for each in passed if robot in each)) > 1
        )
        return Entity(stamp, WORLD, "trails", lines=lines)

    def separating_lines(
        self,
        stamp: Time,
        lines: Mapping[int, tuple[messages.Line, ...]],
        places: Mapping[int, messages.Vector],
    ) -> Entity:
        """What each robot keeps to, near the peer for whose sake it does."""
        pieces = tuple(
            Line(LineType.LIST, points, self._hue(robot))
            for robot, obeyed in lines.items()
            if (points := tuple(point for line in obeyed for point in self._piece(robot, line, places)))
        )
        return Entity(stamp, WORLD, "lines", lines=pieces)

    def _piece(
        self, robot: int, line: messages.Line, places: Mapping[int, messages.Vector]
    ) -> tuple[Vector, ...]:
        """Of the line that a robot keeps to for a peer's sake, what is between the two; empty if they are far
        apart."""
        peer, nx, ny, limit = line
        if peer not in places:
            return ()
        radius = self._radii[robot]
        (x, y), (u, v) = places[robot], places[peer]
        if math.hypot(u - x, v - y) > (2 + _NEAR) * radius:
            return ()
        mx, my = (x + u) / 2, (y + v) / 2
        off, reach = limit - nx * mx - ny * my, 1.1 * radius
        fx, fy = mx + off * nx, my + off * ny
        return _point(fx - ny * reach, fy + nx * reach), _point(fx + ny * reach, fy - nx * reach)

    def _hue(self, robot: int, opacity: float = 1.0) -> Color:
        rank = self._ranks.setdefault(robot, len(self._ranks))
        return _color(_HUES[rank % len(_HUES)], opacity)


def _point(x: float, y: float) -> Vector:
    return Vector(round(x, _DIGITS), round(y, _DIGITS))


@cache
def _color(hexadecimal: str, opacity: float = 1.0) -> Color:
    red, green, blue = (round(part / 255, 3) for part in bytes.fromhex(hexadecimal))
    return Color(red, green, blue, opacity)


def _disk(center: messages.Vector, radius: float, height: float, color: Color) -> Cylinder:
    return Cylinder(Pose(Vector(*center, height / 2)), Vector(2 * radius, 2 * radius, height), color)


def _loop(points: list[messages.Vector], hexadecimal: str) -> Line:
    return Line(LineType.LOOP, tuple(Vector(x, y) for x, y in points), _color(hexadecimal))


def _fan(points: list[messages.Vector], color: Color) -> Triangles:
    """A convex polygon of triangles that share its first corner."""
    first, *others = (Vector(x, y) for x, y in points)
    return Triangles(tuple(corner for pair in pairwise(others) for corner in (first, *pair)), color)
