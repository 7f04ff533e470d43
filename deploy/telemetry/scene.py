"""A fleet as a scene for Foxglove's 3D panel: a view of the run in, messages of the scene's topics out.

Every message is complete, so the newest of each topic suffices wherever a recording is opened. Robots are
drawn once, each in its own frame, which `/tf` moves at little cost.

Drawings are `foxglove.SceneUpdate` and `foxglove.FrameTransforms`, with field names and meanings of Foxglove
(https://docs.foxglove.dev/docs/visualization/message-schemas). Lengths are metres, colours run from 0 to 1.
All fields are always written, since some readers expect them.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from functools import cache
from itertools import pairwise
from typing import Any, NamedTuple

import msgspec

from deploy.telemetry.live import FleetView, RobotView
from protocol.geometry import ConvexPolygon, Shape
from protocol.messages import Clock, GoalStatus, Line, Message, Truth, Vector
from protocol.scenario.model import RobotSpec

JsonObject = dict[str, Any]
WORLD = "world"  # frame of all positions
_DIGITS = 5  # decimals of a metre
_NEAR = 3  # largest gap between robots whose line is drawn, radii
_HUES = ("0072b2", "d98e00", "009e73", "c0629a", "46a6dd", "8a6f3e")
_GREY, _RED, _DARK = "7a828c", "c5161d", "1c1f23"
_STRIP, _LOOP, _LIST = 0, 1, 2  # Foxglove's types of lines
_ALL = 1  # Foxglove's type of a deletion of all earlier entities
_FOR_EVER = {"sec": 0, "nsec": 0}
_UNTURNED = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}


def frame(robot: int) -> str:
    """Name of the frame that moves with a robot."""
    return f"robot_{robot}"


def update(entities: list[JsonObject], gone: JsonObject | None = None) -> JsonObject:
    """An update with new or replaced `entities`; all from before the time `gone` are deleted."""
    deletions = [] if gone is None else [{"timestamp": gone, "type": _ALL, "id": ""}]
    return {"entities": entities, "deletions": deletions}


def frames(stamp: JsonObject, robots: Iterable[RobotView]) -> JsonObject:
    """Frames of robots, without rotation."""
    return {
        "transforms": [
            {
                "timestamp": stamp,
                "parent_frame_id": WORLD,
                "child_frame_id": frame(robot.spec.id),
                "translation": _point(*robot.position),
                "rotation": _UNTURNED,
            }
            for robot in robots
        ]
    }


def room(stamp: JsonObject, boundary: Shape, shapes: Iterable[Shape]) -> JsonObject:
    """Boundary and obstacles."""
    outlines = [boundary.outline(), *(shape.outline() for shape in shapes)]
    edges = [_line(_LOOP, [_point(x, y) for x, y in each], _color(_GREY)) for each in outlines]
    solid = [_fan(each, _color(_GREY, 0.3)) for each in outlines[1:]]
    return _entity(stamp, WORLD, "room", lines=edges, triangles=solid)


def disk(stamp: JsonObject, robot: RobotView) -> JsonObject:
    """One robot, in its own frame; red without a life."""
    number, height = robot.spec.id, robot.radius / 2
    color = _color(_RED) if robot.fenced else _hue(number)
    label = {
        "pose": _pose(_point(0.0, 0.0, 1.5 * height)),
        "billboard": True,
        "font_size": 0.8 * robot.radius,
        "scale_invariant": False,
        "color": _color(_DARK),
        "text": str(number),
    }
    cylinder = _disk((0.0, 0.0), robot.radius, height, color)
    return _entity(stamp, frame(number), f"robot {number}", cylinders=[cylinder], texts=[label])


def goals(stamp: JsonObject, robots: Iterable[RobotView]) -> JsonObject:
    """Known goals of robots."""
    disks = [
        _disk(robot.goal, robot.spec.radius, robot.spec.radius / 50, _hue(robot.spec.id, 0.3))
        for robot in robots
        if robot.goal is not None
    ]
    return _entity(stamp, WORLD, "goals", cylinders=disks)


def trails(stamp: JsonObject, robots: Iterable[RobotView], limit: int) -> JsonObject:
    """Past paths of robots, each of at most about `limit` points."""
    lines = [
        _line(
            _STRIP,
            [_point(*place) for place in places[:: -(-len(places) // limit)]],
            _hue(robot.spec.id, 0.6),
        )
        for robot in robots
        if len(places := robot.trail.items) > 1
    ]
    return _entity(stamp, WORLD, "trails", lines=lines)


def separating_lines(stamp: JsonObject, robots: Mapping[int, RobotView]) -> JsonObject:
    """The lines that each robot obeys, drawn near the peer of each."""
    pieces = [
        _line(_LIST, points, _hue(robot.spec.id))
        for robot in robots.values()
        if (points := [point for line in robot.lines for point in _piece(robot, line, robots)])
    ]
    return _entity(stamp, WORLD, "lines", lines=pieces)


def _piece(robot: RobotView, line: Line, robots: Mapping[int, RobotView]) -> tuple[JsonObject, ...]:
    peer, nx, ny, limit = line
    if peer not in robots:
        return ()
    radius = robot.spec.radius
    (x, y), (u, v) = robot.position, robots[peer].position
    if math.hypot(u - x, v - y) > (2 + _NEAR) * radius:
        return ()
    mx, my = (x + u) / 2, (y + v) / 2
    off, reach = limit - nx * mx - ny * my, 1.1 * radius
    fx, fy = mx + off * nx, my + off * ny
    return _point(fx - ny * reach, fy + nx * reach), _point(fx + ny * reach, fy - nx * reach)


def _hue(robot: int, opacity: float = 1.0) -> JsonObject:
    return _color(_HUES[robot % len(_HUES)], opacity)


def _entity(stamp: JsonObject, frame_id: str, name: str, **primitives: list[JsonObject]) -> JsonObject:
    kinds = ("cylinders", "lines", "triangles", "texts", "metadata", "arrows", "cubes", "spheres", "models")
    return {
        "timestamp": stamp,
        "frame_id": frame_id,
        "id": name,
        "lifetime": _FOR_EVER,
        "frame_locked": True,
    } | {kind: primitives.get(kind, []) for kind in kinds}


def _point(x: float, y: float, z: float = 0.0) -> JsonObject:
    return {"x": round(x, _DIGITS), "y": round(y, _DIGITS), "z": z}


def _pose(position: JsonObject) -> JsonObject:
    return {"position": position, "orientation": _UNTURNED}


@cache
def _color(hexadecimal: str, opacity: float = 1.0) -> JsonObject:
    red, green, blue = (round(part / 255, 3) for part in bytes.fromhex(hexadecimal))
    return {"r": red, "g": green, "b": blue, "a": opacity}


def _disk(center: Vector, radius: float, height: float, color: JsonObject) -> JsonObject:
    size = {"x": 2 * radius, "y": 2 * radius, "z": height}
    pose = _pose({"x": center[0], "y": center[1], "z": height / 2})
    return {"pose": pose, "size": size, "color": color, "bottom_scale": 1.0, "top_scale": 1.0}


def _points(points: list[JsonObject], color: JsonObject) -> JsonObject:
    return {"pose": _pose(_point(0.0, 0.0)), "points": points, "color": color, "colors": [], "indices": []}


def _line(joined: int, points: list[JsonObject], color: JsonObject) -> JsonObject:
    """`foxglove.LinePrimitive`; the thickness is in pixels."""
    return {"type": joined, "thickness": 1.5, "scale_invariant": True} | _points(points, color)


def _fan(outline: list[Vector], color: JsonObject) -> JsonObject:
    """A convex polygon as triangles that share its first corner."""
    first, *others = (_point(x, y) for x, y in outline)
    return _points([corner for pair in pairwise(others) for corner in (first, *pair)], color)


def _schema(value: Any) -> JsonObject:
    if isinstance(value, dict):
        return {"type": "object", "properties": {name: _schema(each) for name, each in value.items()}}
    if isinstance(value, list):
        return {"type": "array", "items": _schema(value[0] if value else {})}
    kinds = {bool: "boolean", int: "integer", float: "number", str: "string"}
    return {"type": kinds[type(value)]}


EXAMPLE = RobotView(RobotSpec(1, 1.0, (0.0, 0.0), (0.0, 0.0)), trail=1)


def example() -> JsonObject:
    """An update with one of each kind of primitive that is drawn."""
    square = ConvexPolygon(((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)))
    around = room(_FOR_EVER, square, [square])
    robot = disk(_FOR_EVER, EXAMPLE)
    return update([{name: around[name] or robot[name] for name in around}], _FOR_EVER)


_SECOND = 1_000_000_000  # ns of simulated time
_PERIODS = {
    "/tf": _SECOND // 10,
    "/measures": _SECOND // 10,
    "/scene/lines": _SECOND,
    "/scene/trails": 2 * _SECOND,
}
_TRAIL_POINTS = 512  # of all robots together


def measures(truth: Truth) -> JsonObject:
    """Smallest gap in the last tick, m, navigation function, and log10(gamma / beta^(1/k))."""
    return {"clearance": truth.clearance, "phi": truth.phi, "log_potential": truth.log_potential}


class SceneTopic(NamedTuple):
    """JSON schema of a topic, with its name."""

    schema: str
    definition: bytes


class Picture(NamedTuple):
    """One message: topic, simulated time, ns, and payload."""

    topic: str
    time: int
    data: bytes


def _topic(name: str, example: JsonObject) -> SceneTopic:
    """Of messages like `example`, which has one item in each list."""
    return SceneTopic(name, json.dumps(_schema(example) | {"title": name}).encode())


_SCENE = _topic("foxglove.SceneUpdate", example())
TOPICS = {
    "/tf": _topic("foxglove.FrameTransforms", frames(_FOR_EVER, [EXAMPLE])),
    "/measures": _topic("disknav.Measures", measures(Truth(0, (), (), 0.0, 1.0))),
    **dict.fromkeys(
        ("/scene/room", "/scene/robots", "/scene/goals", "/scene/lines", "/scene/trails"), _SCENE
    ),
}


class FleetScene:
    """The scene of a view that knows its scenario, at the time of the newest Truth."""

    def __init__(self, view: FleetView) -> None:
        self._view = view
        self._next = dict.fromkeys(_PERIODS, 0)  # ns; next time of each topic
        self._epoch = view.epoch
        self._tick = 0  # of the newest Truth drawn
        self._shown = self._content()

    def whole(self) -> Iterable[Picture]:
        """All topics, for a new viewer."""
        return (picture for topic in TOPICS for picture in self.latest(topic))

    def latest(self, topic: str) -> tuple[Picture, ...]:
        """Newest message of a topic; none of measures before the first Truth."""
        return (self.picture(topic),) if topic != "/measures" or self._view.recent else ()

    def after(self, message: Message) -> list[Picture]:
        """Messages that change with one which the view has taken: those that are due at a Truth, and those
        of robots, goals and obstacles that differ.
        """
        if not isinstance(message, Truth | Clock | GoalStatus):
            return []
        before, self._shown = self._shown, self._content()
        topics = [topic for topic, content in self._shown.items() if content != before[topic]]
        if self._epoch != self._view.epoch:  # robots appeared or left
            self._epoch, self._next = self._view.epoch, dict.fromkeys(_PERIODS, 0)
        if self._view.recent and self._view.recent[-1].tick > self._tick:
            self._tick = self._view.recent[-1].tick
            due = [topic for topic, time in self._next.items() if self._now >= time]
            self._next.update((topic, self._now + _PERIODS[topic]) for topic in due)
            topics += due
        return list(map(self.picture, topics))

    def picture(self, topic: str) -> Picture:
        return Picture(topic, self._now, msgspec.json.encode(self._drawn(topic)))

    def _content(self) -> dict[str, tuple[Any, ...]]:
        """What the messages show that are sent at changes only."""
        robots = self._view.robots.items()
        return {
            "/scene/room": self._view.obstacles,
            "/scene/robots": tuple((robot, each.radius, each.fenced) for robot, each in robots),
            "/scene/goals": tuple((robot, each.goal) for robot, each in robots),
        }

    @property
    def _now(self) -> int:
        """Time of the newest Truth, ns."""
        assert self._view.scenario is not None
        tick = self._view.recent[-1].tick if self._view.recent else 0
        return round(tick * self._view.scenario.time.step * 1e9)

    def _drawn(self, topic: str) -> JsonObject:
        view, stamp = self._view, dict(zip(("sec", "nsec"), divmod(self._now, _SECOND), strict=True))
        assert view.scenario is not None
        robots = view.robots.values()
        match topic:
            case "/tf":
                return frames(stamp, robots)
            case "/measures":
                return measures(view.recent[-1])
            case "/scene/room":
                drawn = room(stamp, view.scenario.workspace.shape, view.shapes.values())
            case "/scene/robots":
                return update([disk(stamp, robot) for robot in robots], stamp)
            case "/scene/goals":
                drawn = goals(stamp, robots)
            case "/scene/lines":
                drawn = separating_lines(stamp, view.robots)
            case _:
                drawn = trails(stamp, robots, max(8, _TRAIL_POINTS // max(1, len(robots))))
        return update([drawn])
