"""A fleet drawn for Foxglove's 3D panel: what a run says goes in, messages for topics of a scene come out.

Every message is whole: the newest of each topic shows all there is, wherever a recording is opened. Robots
are drawn once, each in a frame of its own that `/tf` moves, so that what moves costs little.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from functools import cache, partial
from itertools import pairwise
from typing import NamedTuple

import msgspec

from deploy.scene import ros
from deploy.scene.foxglove import (
    Color,
    Cylinder,
    Entity,
    Line,
    LineType,
    Pose,
    SceneUpdate,
    Text,
    Time,
    Triangles,
    Vector,
    schema,
)
from deploy.scene.thinned import Thinned
from protocol import messages
from protocol.messages import Clock, GoalStatus, Health, Message, Truth
from protocol.scenario.model import Scenario

WORLD = "world"  # the frame in which positions are told
_SECOND = 1_000_000_000  # ns of simulated time
_PERIODS = {
    "/tf": _SECOND // 10,
    "/measures": _SECOND // 10,
    "/scene/lines": _SECOND,
    "/scene/trails": 2 * _SECOND,
}
_TRAIL_POINTS = 512  # of all robots together, at most
_DIGITS = 5  # of a metre
_NEAR = 3  # radii of gap; between robots farther apart no line is drawn
_HUES = ("0072b2", "d98e00", "009e73", "c0629a", "46a6dd", "8a6f3e")
_LATEST = (1 << 31) * _SECOND  # ns that ROS can tell; no tick of a real run is later
_GREY, _RED, _DARK = "7a828c", "c5161d", "1c1f23"


DRAWN = (Truth, Health, GoalStatus, Clock)  # what a scene is made of


class Measures(msgspec.Struct, frozen=True):
    """How the run stands: smallest gap during the tick before, m, and the navigation function."""

    clearance: float
    phi: float


class Topic(NamedTuple):
    """How the messages of a topic are to be read."""

    encoding: str
    schema: str
    schema_encoding: str
    definition: bytes


class Picture(NamedTuple):
    """One message: simulated time, ns, and payload."""

    topic: str
    time: int
    data: bytes


_SCENE = Topic("json", "foxglove.SceneUpdate", "jsonschema", schema(SceneUpdate, "foxglove.SceneUpdate"))
TOPICS = {
    "/tf": Topic("cdr", ros.NAME, "ros2msg", ros.DEFINITION.encode()),
    "/measures": Topic("json", "disknav.Measures", "jsonschema", schema(Measures, "disknav.Measures")),
    **dict.fromkeys(
        ("/scene/room", "/scene/robots", "/scene/goals", "/scene/lines", "/scene/trails"), _SCENE
    ),
}


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


class FleetScene:
    """The scene of one run; time is that of the newest truth."""

    def __init__(self, scenario: Scenario) -> None:
        self._scenario = scenario
        self._now = 0
        self._known = {robot: scenario.spec(robot).start for robot in scenario.ids}
        self._truth = Truth(0, (), (), 0.0, 1.0)
        self._goals = {robot: scenario.spec(robot).goal for robot in scenario.ids}
        self._down: frozenset[int] = frozenset()
        self._things = dict(scenario.shapes)
        self._told = Clock(0, 0.0, (), (), "")
        self._lines: dict[int, tuple[messages.Line, ...]] = {}
        limit = max(8, _TRAIL_POINTS // len(scenario.ids))
        self._past: Thinned[Moment] = Thinned(limit, lambda _, later: later)
        self._moving = ros.Frames(WORLD, [frame(robot) for robot in scenario.ids])
        self._next = dict.fromkeys(_PERIODS, 0)  # ns; when a topic is due
        self._due = 0  # ns; when the first of them is
        self._draw: dict[str, Callable[[], bytes]] = {
            "/tf": self._frames,
            "/measures": self._measures,
            **{topic: partial(_update, draw) for topic, draw in self._entities().items()},
        }

    def whole(self) -> Iterator[Picture]:
        """All of it, for who has just come."""
        return map(self.picture, TOPICS)

    def picture(self, topic: str) -> Picture:
        """One topic of it."""
        return Picture(topic, self._now, self._draw[topic]())

    def hear(self, message: Message) -> Iterator[Picture]:
        """Take over what was published; gives what is to be drawn anew because of it."""
        if isinstance(message, Truth):
            return map(self.picture, self._on_truth(message))
        if isinstance(message, Health) and message.robot in self._known:
            self._lines[message.robot] = message.lines
        elif isinstance(message, GoalStatus) and message.robot in self._goals:
            self._goals[message.robot] = message.goal
            return iter((self.picture("/scene/goals"),))
        elif isinstance(message, Clock):
            return map(self.picture, self._on_clock(message))
        return iter(())

    def _on_clock(self, clock: Clock) -> list[str]:
        """Which topics are changed by who is down, and by what came or went."""
        if clock.standing == self._told.standing and clock.things == self._told.things:
            return []
        self._told = clock
        before = self._down, self._things
        self._down = frozenset(each.robot for each in clock.standing)
        gone = {thing.number for thing in clock.things}
        came = {thing.number: thing.shape for thing in clock.things if thing.status == "standing"}
        listed = {number: shape for number, shape in self._scenario.shapes.items() if number not in gone}
        self._things = listed | came
        changed = (self._down != before[0], self._things != before[1])
        return [topic for topic, new in zip(("/scene/robots", "/scene/room"), changed, strict=True) if new]

    def _on_truth(self, truth: Truth) -> list[str]:
        """Which topics are due."""
        now = round(truth.tick * self._scenario.time.step * 1e9)
        if now >= _LATEST:
            return []
        self._now, self._truth = now, truth
        if now < self._due:
            return []
        due = [topic for topic, time in self._next.items() if now >= time]
        for topic in due:
            self._next[topic] = now + _PERIODS[topic]
        self._due = min(self._next.values())
        if "/tf" in due:
            self._past.append(Moment(dict(self._places)))
        return due

    @property
    def _places(self) -> dict[int, messages.Vector]:
        """Where the robots of the scenario were last, m; at their starts before anything was said of them."""
        told = zip(self._truth.robots, self._truth.positions, strict=False)
        self._known.update((robot, place) for robot, place in told if robot in self._known)
        return self._known

    @property
    def _stamp(self) -> Time:
        return Time(*divmod(self._now, _SECOND))

    # -- what is drawn

    def _entities(self) -> dict[str, Callable[[], tuple[Entity, ...]]]:
        return {
            "/scene/room": self._room,
            "/scene/robots": self._robots,
            "/scene/goals": self._goal_disks,
            "/scene/lines": self._separating_lines,
            "/scene/trails": self._trail_lines,
        }

    def _measures(self) -> bytes:
        return msgspec.json.encode(Measures(self._truth.clearance, self._truth.phi))

    def _frames(self) -> bytes:
        return self._moving.message(self._now, self._places.values())

    def _room(self) -> tuple[Entity, ...]:
        shapes = self._things.values()
        edges = [_loop(self._scenario.workspace.shape.outline(), _GREY)]
        edges += [_loop(shape.outline(), _GREY) for shape in shapes]
        solid = tuple(_fan(shape.outline(), _color(_GREY, 0.3)) for shape in shapes)
        return (Entity(self._stamp, WORLD, "room", lines=tuple(edges), triangles=solid),)

    def _robots(self) -> tuple[Entity, ...]:
        return tuple(self._robot(robot) for robot in self._scenario.ids)

    def _robot(self, robot: int) -> Entity:
        radius = self._scenario.spec(robot).radius
        height = radius / 2
        color = _color(_RED) if robot in self._down else self._hue(robot)
        disk = _disk((0.0, 0.0), radius, height, color)
        label = Text(Pose(Vector(z=1.5 * height)), 0.8 * radius, _color(_DARK), str(robot))
        return Entity(self._stamp, frame(robot), f"robot {robot}", cylinders=(disk,), texts=(label,))

    def _goal_disks(self) -> tuple[Entity, ...]:
        disks = tuple(
            _disk(goal, radius := self._scenario.spec(robot).radius, radius / 50, self._hue(robot, 0.3))
            for robot, goal in self._goals.items()
        )
        return (Entity(self._stamp, WORLD, "goals", cylinders=disks),)

    def _trail_lines(self) -> tuple[Entity, ...]:
        moments = [moment.points for moment in self._past.items]
        lines = tuple(
            Line(LineType.STRIP, tuple(points[robot] for points in moments), self._hue(robot, 0.6))
            for robot in (self._known if len(moments) > 1 else ())
        )
        return (Entity(self._stamp, WORLD, "trails", lines=lines),)

    def _separating_lines(self) -> tuple[Entity, ...]:
        places = self._places
        lines = tuple(
            Line(LineType.LIST, points, self._hue(robot))
            for robot, obeyed in self._lines.items()
            if (points := tuple(point for line in obeyed for point in self._piece(robot, line, places)))
        )
        return (Entity(self._stamp, WORLD, "lines", lines=lines),)

    def _piece(
        self, robot: int, line: messages.Line, places: Mapping[int, messages.Vector]
    ) -> tuple[Vector, ...]:
        """Of the line that a robot keeps to for a peer's sake, what is between the two; empty if they are far
        apart."""
        peer, nx, ny, limit = line
        if peer not in places:
            return ()
        radius = self._scenario.spec(robot).radius
        (x, y), (u, v) = places[robot], places[peer]
        if math.hypot(u - x, v - y) > (2 + _NEAR) * radius:
            return ()
        mx, my = (x + u) / 2, (y + v) / 2
        off, reach = limit - nx * mx - ny * my, 1.1 * radius
        fx, fy = mx + off * nx, my + off * ny
        return _point(fx - ny * reach, fy + nx * reach), _point(fx + ny * reach, fy - nx * reach)

    def _hue(self, robot: int, opacity: float = 0.9) -> Color:
        return _color(_HUES[self._scenario.ids.index(robot) % len(_HUES)], opacity)


def _update(draw: Callable[[], tuple[Entity, ...]]) -> bytes:
    return msgspec.json.encode(SceneUpdate(draw()))


def frame(robot: int) -> str:
    """The frame that moves with a robot."""
    return f"robot_{robot}"


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
