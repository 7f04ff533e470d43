"""What a world is told, as plain values: its state follows from them and its scenario, and from nothing else.

A `Command` stands for itself. On disk each is one msgpack array that begins with its tag.
"""

from __future__ import annotations

import zlib
from collections.abc import Sequence

import msgspec

from protocol.messages import Command, Count, Id, Vector
from protocol.requests.goals import GoalOrder
from protocol.requests.things import ThingOrder
from protocol.scenario.model import RobotSpec


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


class Ordered(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="order"):
    """See `World.order`."""

    robot: Id
    order: GoalOrder


class Placed(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="place"):
    """See `World.add_thing`."""

    order: ThingOrder


class TakenAway(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="take away"):
    """See `World.remove_thing`."""

    number: Id


class Halted(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="halt"):
    """See `World.halt`."""

    halted: bool


class Contested(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="contest"):
    """See `World.contest`."""

    contested: bool


class Added(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="add"):
    """See `World.add`."""

    spec: RobotSpec


class Removed(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="remove"):
    """See `World.remove`."""

    robot: Id


_encode = msgspec.msgpack.encode

Operated = Ordered | Placed | TakenAway | Added | Removed | Halted
Input = Command | Opened | Closed | Joined | Lost | Expected | GivenUp | Operated | Contested | Ended


def checksum(positions: Sequence[Vector]) -> int:
    """Of positions, to the last bit."""
    return zlib.crc32(_encode(positions))
