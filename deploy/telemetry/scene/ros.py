"""Where robots are as ROS 2 has it: `tf2_msgs/msg/TFMessage` in CDR, which Foxglove reads, too."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from itertools import chain

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
_UNTURNED = (0.0, 0.0, 0.0, 0.0, 1.0)  # height, and a rotation by nothing


class Frames:
    """Frames named `children` that move within the frame `parent`."""

    def __init__(self, parent: str, children: Sequence[str]) -> None:
        form, size = "<4sI", 4  # numbers stand at multiples of their size, counted after the first 4 bytes
        for child in children:
            for piece, align, length in (
                ("iI", 4, 8),
                *((f"I{len(name) + 1}s", 4, 4 + len(name) + 1) for name in (parent, child)),
                ("7d", 8, 56),
            ):
                pad = -size % align
                form, size = f"{form}{pad}x{piece}", size + pad + length
        self._layout = struct.Struct(form)
        self._names = [
            (len(parent) + 1, parent.encode(), len(child) + 1, child.encode()) for child in children
        ]

    def message(self, nanoseconds: int, places: Iterable[Vector]) -> bytes:
        """The payload that puts the frames at places, m, in the order of their names, unturned."""
        stamp = divmod(nanoseconds, 1_000_000_000)
        parts = [
            (*stamp, *names, *place, *_UNTURNED) for names, place in zip(self._names, places, strict=True)
        ]
        return self._layout.pack(_LITTLE_ENDIAN, len(parts), *chain.from_iterable(parts))
