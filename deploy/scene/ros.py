"""Where robots are as ROS 2 has it: `tf2_msgs/msg/TFMessage` in CDR, which Foxglove reads, too."""

from __future__ import annotations

import struct
from collections.abc import Mapping

from protocol.messages import Vector

NAME = "tf2_msgs/msg/TFMessage"
DEFINITION = """\
geometry_msgs/TransformStamped[] transforms
================================================================================
MSG: geometry_msgs/TransformStamped
std_msgs/Header header
string child_frame_id
geometry_msgs/Transform transform
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: geometry_msgs/Transform
geometry_msgs/Vector3 translation
geometry_msgs/Quaternion rotation
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
================================================================================
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
"""

_LITTLE_ENDIAN = b"\0\1\0\0"
_TIME, _LENGTH, _POSE = struct.Struct("<iI"), struct.Struct("<I"), struct.Struct("<7d")


def transforms(nanoseconds: int, parent: str, places: Mapping[str, Vector]) -> bytes:
    """The payload that puts frames at places, m, within the frame `parent`, unturned."""
    stamp = _TIME.pack(*divmod(nanoseconds, 1_000_000_000))
    above = stamp + _text(parent)
    content = bytearray(_LENGTH.pack(len(places)))
    for child, (x, y) in places.items():
        _align(content, 4)
        content += above
        _align(content, 4)
        content += _text(child)
        _align(content, 8)
        content += _POSE.pack(x, y, 0.0, 0.0, 0.0, 0.0, 1.0)
    return _LITTLE_ENDIAN + content


def _text(text: str) -> bytes:
    data = text.encode() + b"\0"
    return _LENGTH.pack(len(data)) + data


def _align(content: bytearray, size: int) -> None:
    """Numbers stand at multiples of their size."""
    content += bytes(-len(content) % size)
