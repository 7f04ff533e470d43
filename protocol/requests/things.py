"""Things that come and go while a fleet runs: a request under `world/things`, which the world answers.

`{"place": {"center": [x, y], "radius": r}}` or `{"place": {"points": [[x, y], ...]}}` has a disk or a convex
polygon appear once every robot keeps clear of its place; `{"take": 3}` says that thing 3 was taken away. An
empty request asks what is there. The reply has `accepted`, `number` of the thing, `text` (why not, or what
to beware of) and `things`, all that stand or are to appear. Maps in msgpack, or JSON text; the reply comes
in the form of the request.
"""

from __future__ import annotations

from typing import Annotated

import msgspec
from msgspec import Meta

from protocol.errors import MessageError
from protocol.geometry import ConvexPolygon, Disk, Shape, defect
from protocol.messages import Count, Id, Size, Thing, Vector
from protocol.requests.form import read_request
from protocol.scenario.body import FARTHEST

LIMIT = 16 * 1024  # bytes of a request
MOST_CORNERS = 64


class ThingOrder(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A thing to be put up: a disk (`center`, `radius`) or a convex polygon (`points`), m."""

    center: Vector | None = None
    radius: Size | None = None
    points: Annotated[tuple[Vector, ...], Meta(max_length=MOST_CORNERS)] = ()

    def defect(self) -> str:
        """Why it is no shape, "" if it is one."""
        if self.points:
            if self.center is not None or self.radius is not None:
                return "is a disk, with `center` and `radius`, or a polygon, with `points`, not both"
            if not _is_near(*(part for point in self.points for part in point)):
                return "has a coordinate that is no number of reasonable size"
            return defect(self.points)
        if self.center is None or self.radius is None:
            return "needs `center` and `radius`, or `points`"
        if not (_is_near(*self.center, self.radius) and self.radius > 0.0):
            return "has a number that is not of reasonable size"
        return ""

    @property
    def shape(self) -> Shape:
        """Of an order without defect."""
        if self.points:
            return ConvexPolygon(self.points)
        assert self.center is not None
        assert self.radius is not None
        return Disk(self.center[0], self.center[1], self.radius)


class ThingChange(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What is asked: one of both."""

    place: ThingOrder | None = None
    take: Id | None = None

    def __str__(self) -> str:
        return f"thing {self.take} goes" if self.place is None else "a thing comes"


class ThingReply(msgspec.Struct, frozen=True):
    """Whether a thing was accepted, or taken away.

    Attributes:
        number: of the thing; 0 if it was refused.
        text: why it was refused, or what to beware of.
        things: all that stand or are to appear.
    """

    accepted: bool
    number: Count = 0
    text: str = ""
    things: tuple[Thing, ...] = ()


def decode_thing_change(payload: bytes) -> ThingChange | None:
    """Read a request; None if it only asks.

    Raises:
        MessageError: it is none, or asks for both or neither.
    """
    if not payload:
        return None
    change = read_request(payload, ThingChange, "things", LIMIT)
    if (change.place is None) == (change.take is None):
        raise MessageError("shape", "things request: give either `place` or `take`")
    return change


def _is_near(*numbers: float) -> bool:
    return all(abs(number) <= FARTHEST for number in numbers)
