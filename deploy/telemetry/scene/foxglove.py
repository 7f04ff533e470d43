"""Foxglove's scene: the parts of `foxglove.SceneUpdate` that a fleet needs, as JSON with an inline schema.

Field names and meanings are Foxglove's (https://docs.foxglove.dev/docs/visualization/message-schemas).
Lengths are metres, colours run from 0 to 1.
"""

from __future__ import annotations

import json
from enum import IntEnum
from typing import Any

import msgspec


class Time(msgspec.Struct, frozen=True):
    """Seconds and nanoseconds; as a duration, zero is for ever."""

    sec: int = 0
    nsec: int = 0


class Vector(msgspec.Struct, frozen=True):
    """A point or a size."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0


class Quaternion(msgspec.Struct, frozen=True):
    """A rotation; none unless told."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    w: float = 1.0


class Pose(msgspec.Struct, frozen=True):
    """Where the origin of a primitive is, within the frame of its entity."""

    position: Vector = Vector()
    orientation: Quaternion = Quaternion()


class Color(msgspec.Struct, frozen=True):
    """Red, green, blue, opacity."""

    r: float
    g: float
    b: float
    a: float = 1.0


class LineType(IntEnum):
    """How points are joined."""

    STRIP = 0
    LOOP = 1
    LIST = 2


class Cylinder(msgspec.Struct, frozen=True):
    """An upright one around the origin of its pose."""

    pose: Pose
    size: Vector
    color: Color
    bottom_scale: float = 1.0
    top_scale: float = 1.0


class Line(msgspec.Struct, frozen=True):
    """Joined points; the thickness is pixels."""

    type: LineType
    points: tuple[Vector, ...]
    color: Color
    thickness: float = 1.5
    pose: Pose = Pose()
    scale_invariant: bool = True
    colors: tuple[Color, ...] = ()
    indices: tuple[int, ...] = ()


class Triangles(msgspec.Struct, frozen=True):
    """Every three points are one."""

    points: tuple[Vector, ...]
    color: Color
    pose: Pose = Pose()
    colors: tuple[Color, ...] = ()
    indices: tuple[int, ...] = ()


class Text(msgspec.Struct, frozen=True):
    """Faces whoever looks; the size is metres."""

    pose: Pose
    font_size: float
    color: Color
    text: str
    billboard: bool = True
    scale_invariant: bool = False


class Entity(msgspec.Struct, frozen=True):
    """What is drawn under one id until it is replaced, in a frame with which it moves."""

    timestamp: Time
    frame_id: str
    id: str
    lifetime: Time = Time()
    frame_locked: bool = True
    cylinders: tuple[Cylinder, ...] = ()
    lines: tuple[Line, ...] = ()
    triangles: tuple[Triangles, ...] = ()
    texts: tuple[Text, ...] = ()
    # Nothing of these, but who reads it may expect them.
    metadata: tuple[Vector, ...] = ()
    arrows: tuple[Vector, ...] = ()
    cubes: tuple[Vector, ...] = ()
    spheres: tuple[Vector, ...] = ()
    models: tuple[Vector, ...] = ()


class DeletionType(IntEnum):
    """What goes of a topic."""

    MATCHING_ID = 0
    ALL = 1


class Deletion(msgspec.Struct, frozen=True):
    """Entities of the topic go that are earlier than this."""

    timestamp: Time
    type: DeletionType = DeletionType.ALL
    id: str = ""


class SceneUpdate(msgspec.Struct, frozen=True):
    """Entities that go, and those that come, or replace those of the same ids."""

    entities: tuple[Entity, ...]
    deletions: tuple[Deletion, ...] = ()


def schema(struct: type[msgspec.Struct], title: str) -> bytes:
    """JSON schema of a struct without references, which Foxglove does not follow."""
    (whole,), definitions = msgspec.json.schema_components([struct], ref_template="{name}")
    content = _inline(definitions[whole["$ref"]], definitions)
    return json.dumps(content | {"title": title}).encode()


def _inline(node: dict[str, Any], definitions: dict[str, Any]) -> dict[str, Any]:
    if "$ref" in node:
        return _inline(definitions[node["$ref"]], definitions)
    if "enum" in node:
        return {"type": "integer"}
    found: dict[str, Any] = {"type": node["type"]}
    if "properties" in node:
        found["properties"] = {name: _inline(each, definitions) for name, each in node["properties"].items()}
    if "items" in node:
        found["items"] = _inline(node["items"], definitions)
    return found
