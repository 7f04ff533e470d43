"""What a world is told, as plain values: its state follows from them and its scenario, and from nothing else.

A `Command` and an `Operation` stand for themselves. On disk an operation is a msgpack map, all others are
arrays that begin with a tag.
"""

from __future__ import annotations

import zlib
from collections.abc import Sequence

import msgspec

from protocol.messages import Command, Count, Id, Vector
from protocol.scenario.model import Operation


class Joined(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="join"):
    """A process took over a robot, as this incarnation."""

    robot: Id
    incarnation: Count


class Lost(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="lost"):
    """See `Coordinator.lost`."""

    robot: Id
    reason: str = ""


class Expected(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="expect"):
    """See `Coordinator.expect`."""

    robot: Id


class GivenUp(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="give up"):
    """See `Coordinator.give_up_waiting`."""

    robot: Id
    reason: str = ""


class Opened(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="open"):
    """Somebody tried to open the tick; it did open unless robots were awaited."""


class Closed(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="close"):
    """The tick ended."""

    checksum: Count  # of where every disk was then


class Ended(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="end"):
    """See `World.finish`."""

    verdict: str
    reason: str


class Contested(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="contest"):
    """See `World.contest`."""

    contested: bool


_encode = msgspec.msgpack.encode

Input = Command | Opened | Closed | Joined | Lost | Expected | GivenUp | Operation | Contested | Ended


def checksum(positions: Sequence[Vector]) -> int:
    """Of positions, to the last bit."""
    return zlib.crc32(_encode(positions))
