"""Drawing a fleet for Foxglove's 3D panel, as `foxglove.SceneUpdate` and `foxglove.FrameTransforms`.

Field names and meanings are Foxglove's (https://docs.foxglove.dev/docs/visualization/message-schemas).
Lengths are metres, colours run from 0 to 1. All fields are always written, since some readers expect them.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from functools import cache
from itertools import pairwise
from typing import Any

from deploy.telemetry.live import RobotView
from protocol.geometry import ConvexPolygon, Shape
from protocol.messages import Line, Vector
from protocol.scenario.model import RobotSpec

Json = dict[str, Any]
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


def update(entities: list[Json], gone: Json | None = None) -> Json:
    """An update with new or replaced `entities`; all from before the time `gone` are deleted."""
    deletions = [] if gone is None else [{"timestamp": gone, "type": _ALL, "id": ""}]
    return {"entities": entities, "deletions": deletions}


def frames(stamp: Json, robots: Iterable[RobotView]) -> Json:
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


def room(stamp: Json, boundary: Shape, shapes: Iterable[Shape]) -> Json:
    """Boundary and obstacles."""
    outlines = [boundary.outline(), *(shape.outline() for shape in shapes)]
    edges = [_line(_LOOP, [_point(x, y) for x, y in each], _color(_GREY)) for each in outlines]
    solid = [_fan(each, _color(_GREY, 0.3)) for each in outlines[1:]]
    return _entity(stamp, WORLD, "room", lines=edges, triangles=solid)


def disk(stamp: Json, robot: RobotView) -> Json:
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


def goals(stamp: Json, robots: Iterable[RobotView]) -> Json:
    """Known goals of robots."""
    disks = [
        _disk(robot.goal, robot.spec.radius, robot.spec.radius / 50, _hue(robot.spec.id, 0.3))
        for robot in robots
        if robot.goal is not None
    ]
    return _entity(stamp, WORLD, "goals", cylinders=disks)


def trails(stamp: Json, robots: Iterable[RobotView], limit: int) -> Json:
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


def separating_lines(stamp: Json, robots: Mapping[int, RobotView]) -> Json:
    """The lines that each robot obeys, drawn near the peer of each."""
    pieces = [
        _line(_LIST, points, _hue(robot.spec.id))
        for robot in robots.values()
        if (points := [point for line in robot.lines for point in _piece(robot, line, robots)])
    ]
    return _entity(stamp, WORLD, "lines", lines=pieces)


def _piece(robot: RobotView, line: Line, robots: Mapping[int, RobotView]) -> tuple[Json, ...]:
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


def _hue(robot: int, opacity: float = 1.0) -> Json:
    return _color(_HUES[robot % len(_HUES)], opacity)


def _entity(stamp: Json, frame_id: str, name: str, **primitives: list[Json]) -> Json:
    kinds = ("cylinders", "lines", "triangles", "texts", "metadata", "arrows", "cubes", "spheres", "models")
    return {
        "timestamp": stamp,
        "frame_id": frame_id,
        "id": name,
        "lifetime": _FOR_EVER,
        "frame_locked": True,
    } | {kind: primitives.get(kind, []) for kind in kinds}


def _point(x: float, y: float, z: float = 0.0) -> Json:
    return {"x": round(x, _DIGITS), "y": round(y, _DIGITS), "z": z}


def _pose(position: Json) -> Json:
    return {"position": position, "orientation": _UNTURNED}


@cache
def _color(hexadecimal: str, opacity: float = 1.0) -> Json:
    red, green, blue = (round(part / 255, 3) for part in bytes.fromhex(hexadecimal))
    return {"r": red, "g": green, "b": blue, "a": opacity}


def _disk(center: Vector, radius: float, height: float, color: Json) -> Json:
    size = {"x": 2 * radius, "y": 2 * radius, "z": height}
    pose = _pose({"x": center[0], "y": center[1], "z": height / 2})
    return {"pose": pose, "size": size, "color": color, "bottom_scale": 1.0, "top_scale": 1.0}


def _points(points: list[Json], color: Json) -> Json:
    return {"pose": _pose(_point(0.0, 0.0)), "points": points, "color": color, "colors": [], "indices": []}


def _line(joined: int, points: list[Json], color: Json) -> Json:
    """`foxglove.LinePrimitive`; the thickness is in pixels."""
    return {"type": joined, "thickness": 1.5, "scale_invariant": True} | _points(points, color)


def _fan(outline: list[Vector], color: Json) -> Json:
    """A convex polygon as triangles that share its first corner."""
    first, *others = (_point(x, y) for x, y in outline)
    return _points([corner for pair in pairwise(others) for corner in (first, *pair)], color)


def schema(title: str, example: Json) -> bytes:
    """JSON schema of values like `example`, which has one item in each list."""
    return json.dumps(_schema(example) | {"title": title}).encode()


def _schema(value: Any) -> Json:
    if isinstance(value, dict):
        return {"type": "object", "properties": {name: _schema(each) for name, each in value.items()}}
    if isinstance(value, list):
        return {"type": "array", "items": _schema(value[0] if value else {})}
    kinds = {bool: "boolean", int: "integer", float: "number", str: "string"}
    return {"type": kinds[type(value)]}


EXAMPLE = RobotView(RobotSpec(1, 1.0, (0.0, 0.0), (0.0, 0.0)), trail=1)


def example() -> Json:
    """An update with one of each kind of primitive that is drawn."""
    square = ConvexPolygon(((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)))
    around = room(_FOR_EVER, square, [square])
    robot = disk(_FOR_EVER, EXAMPLE)
    return update([{name: around[name] or robot[name] for name in around}], _FOR_EVER)
