"""Things that come and go while a fleet runs: what an operator asks for, and what is answered."""

from __future__ import annotations

import math
from typing import Annotated

import msgspec
from msgspec import Meta

from protocol.geometry import ConvexPolygon, Disk, Shape
from protocol.geometry.defects import defect
from protocol.messages import Count, Vector

MOST_CORNERS = 64
_LARGEST = 1e6  # m


class ThingOrder(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A thing to be put up: a disk (`center`, `radius`) or a convex polygon (`points`), m."""

    center: Vector | None = None
    radius: float | None = None
    points: Annotated[tuple[Vector, ...], Meta(max_length=MOST_CORNERS)] = ()

    def defect(self) -> str:
        """Why it is no shape, "" if it is one."""
        if self.points:
            if self.center is not None or self.radius is not None:
                return "is a disk, with `center` and `radius`, or a polygon, with `points`, not both"
            if not _is_finite(*(part for point in self.points for part in point)):
                return "has a coordinate that is no number of reasonable size"
            return defect(self.points)
        if self.center is None or self.radius is None:
            return "needs `center` and `radius`, or `points`"
        if not (_is_finite(*self.center, self.radius) and self.radius > 0.0):
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


class ThingReply(msgspec.Struct, frozen=True):
    """Whether a thing was accepted, or taken away.

    Attributes:
        number: of the thing; 0 if it was refused.
        text: why it was refused, or what to beware of.
    """

    accepted: bool
    number: Count = 0
    text: str = ""


def _is_finite(*numbers: float) -> bool:
    return all(math.isfinite(number) and abs(number) <= _LARGEST for number in numbers)
