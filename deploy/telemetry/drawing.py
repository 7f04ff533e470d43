"""Drawing a fleet for Foxglove's 3D panel, as `foxglove.SceneUpdate` and `foxglove.FrameTransforms`.

Field names and meanings are Foxglove's (https://docs.foxglove.dev/docs/visualization/message-schemas).
Lengths are metres, colours run from 0 to 1. All fields are always written, since some readers expect them.
"""

from __future__ import annotations

import json
import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import cache
from itertools import pairwise
from typing import Any

from protocol import messages
from protocol.geometry import ConvexPolygon, Shape
from protocol.scenario.model import RobotSpec, Scenario

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


def frames(stamp: Json, places: Mapping[int, messages.Vector]) -> Json:
    """Frames of robots at `places`, m, without rotation."""
    return {
        "transforms": [
            {
                "timestamp": stamp,
                "parent_frame_id": WORLD,
                "child_frame_id": frame(robot),
                "translation": _point(*place),
                "rotation": _UNTURNED,
            }
            for robot, place in places.items()
        ]
    }


class Drawing:
    """Draws the robots of one run. The first argument of its methods is the time of the drawing.

    Args:
        radii: of all robots to draw, m; the mapping may grow later.
    """

    def __init__(self, scenario: Scenario, radii: Mapping[int, float]) -> None:
        self._scenario, self._radii = scenario, radii
        self._ranks = {robot: rank for rank, robot in enumerate(scenario.ids)}

    def room(self, stamp: Json, shapes: Collection[Shape]) -> Json:
        """Boundary and obstacles."""
        outlines = [self._scenario.workspace.shape.outline(), *(shape.outline() for shape in shapes)]
        edges = [_line(_LOOP, [_point(x, y) for x, y in each], _color(_GREY)) for each in outlines]
        solid = [_fan(each, _color(_GREY, 0.3)) for each in outlines[1:]]
        return _entity(stamp, WORLD, "room", lines=edges, triangles=solid)

    def robot(self, stamp: Json, robot: int, *, down: bool) -> Json:
        """One robot, in its own frame."""
        radius = self._radii[robot]
        height = radius / 2
        disk = _disk((0.0, 0.0), radius, height, _color(_RED) if down else self._hue(robot))
        label = {
            "pose": _pose(_point(0.0, 0.0, 1.5 * height)),
            "billboard": True,
            "font_size": 0.8 * radius,
            "scale_invariant": False,
            "color": _color(_DARK),
            "text": str(robot),
        }
        return _entity(stamp, frame(robot), f"robot {robot}", cylinders=[disk], texts=[label])

    def goals(self, stamp: Json, goals: Mapping[int, messages.Vector]) -> Json:
        """Goals of robots, m."""
        disks = [
            _disk(goal, radius := self._radii[robot], radius / 50, self._hue(robot, 0.3))
            for robot, goal in goals.items()
        ]
        return _entity(stamp, WORLD, "goals", cylinders=disks)

    def trails(
        self, stamp: Json, moments: Sequence[Mapping[int, messages.Vector]], robots: Iterable[int]
    ) -> Json:
        """Past paths of robots."""
        lines = [
            _line(_STRIP, [_point(*place) for place in places], self._hue(robot, 0.6))
            for robot in robots
            if len(places := [each[robot] for each in moments if robot in each]) > 1
        ]
        return _entity(stamp, WORLD, "trails", lines=lines)

    def separating_lines(
        self,
        stamp: Json,
        lines: Mapping[int, tuple[messages.Line, ...]],
        places: Mapping[int, messages.Vector],
    ) -> Json:
        """The lines that each robot obeys, drawn near the peer of each."""
        pieces = [
            _line(_LIST, points, self._hue(robot))
            for robot, obeyed in lines.items()
            if (points := [point for line in obeyed for point in self._piece(robot, line, places)])
        ]
        return _entity(stamp, WORLD, "lines", lines=pieces)

    def _piece(
        self, robot: int, line: messages.Line, places: Mapping[int, messages.Vector]
    ) -> tuple[Json, ...]:
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

    def _hue(self, robot: int, opacity: float = 1.0) -> Json:
        rank = self._ranks.setdefault(robot, len(self._ranks))
        return _color(_HUES[rank % len(_HUES)], opacity)


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


def _disk(center: messages.Vector, radius: float, height: float, color: Json) -> Json:
    size = {"x": 2 * radius, "y": 2 * radius, "z": height}
    pose = _pose({"x": center[0], "y": center[1], "z": height / 2})
    return {"pose": pose, "size": size, "color": color, "bottom_scale": 1.0, "top_scale": 1.0}


def _points(points: list[Json], color: Json) -> Json:
    return {"pose": _pose(_point(0.0, 0.0)), "points": points, "color": color, "colors": [], "indices": []}


def _line(joined: int, points: list[Json], color: Json) -> Json:
    """`foxglove.LinePrimitive`; the thickness is in pixels."""
    return {"type": joined, "thickness": 1.5, "scale_invariant": True} | _points(points, color)


def _fan(outline: list[messages.Vector], color: Json) -> Json:
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


def example() -> Json:
    """An update with one of each kind of primitive that is drawn."""
    square = ConvexPolygon(((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)))
    drawing = Drawing(Scenario((RobotSpec(1, 1.0, (0.0, 0.0), (0.0, 0.0)),)), {1: 1.0})
    room, robot = drawing.room(_FOR_EVER, [square]), drawing.robot(_FOR_EVER, 1, down=False)
    whole = {name: room[name] or robot[name] for name in room}
    return update([whole], _FOR_EVER)
