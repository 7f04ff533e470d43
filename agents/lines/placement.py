"""Where the owner puts the next line of a pair.

Nothing here can be unsafe: an owner offers only lines that the own body satisfies, and a follower adopts only
those that its own body satisfies.
"""

from __future__ import annotations

import math
from typing import Final, final

from mypy_extensions import mypyc_attr

from protocol.line import ROUNDING, SURE, Line
from protocol.messages import Vector

Span = tuple[Vector, Vector]  # a point of each of two segments

_BISECTIONS: Final = 8
_NEED: Final = 4.0 * ROUNDING  # gap that a line takes, m
_MOST: Final = 0.99  # of a gap, that is kept as standoffs


@final
@mypyc_attr(acyclic=True)
class Disk:
    """One robot as the owner of a line sees it: centre, radius and error bound (m), desired velocity, and the
    one that it was last seen to have."""

    __slots__ = ("radius", "ux", "uy", "vx", "vy", "x", "y")

    def __init__(
        self,
        x: float,
        y: float,
        radius: float,
        vx: float = 0.0,
        vy: float = 0.0,
        ux: float = 0.0,
        uy: float = 0.0,
    ) -> None:
        self.x, self.y, self.radius = x, y, radius
        self.vx, self.vy, self.ux, self.uy = vx, vy, ux, uy


def is_same(one: Line, other: Line, tolerance: float) -> bool:
    """Whether two lines differ by less than `tolerance` (m, and per metre along the line)."""
    return (
        abs(one.nx - other.nx) < tolerance
        and abs(one.ny - other.ny) < tolerance
        and abs(one.offset - other.offset) < tolerance
    )


def fit_line(
    owner: Disk,
    follower: Disk,
    *,
    ahead: float = 0.0,
    begin: float = 0.0,
    end: float = 0.0,
    share: float = 0.5,
    standoff: float = 0.0,
) -> Line | None:
    """The line that lets both do what they want for the longest time.

    The owner obeys it at once: its disk sweeps along its desired velocity for `ahead` seconds. The follower
    obeys it from `begin` to `end` seconds after it was where the owner sees it: its disk sweeps from where it
    is then, if it goes on as it was seen to, to where its desired velocity leads. The line separates the two
    swept areas, and leaves the owner `share` of the gap between them. If they meet, all times are
    the same largest fraction of what they should be, so two that drive at each other share the gap in
    proportion to what each wants of it. Either keeps a `standoff` (m), the owner first: where the gap seen is
    less than two, one at least can make room.

    None when the disks were not seen apart, and will not be if both do as they want.
    """
    mine = theirs = 0.0
    if standoff > 0.0:
        gap = math.hypot(follower.x - owner.x, follower.y - owner.y) - owner.radius - follower.radius
        room = max(0.0, _MOST * (gap - _NEED))
        mine, theirs = min(standoff, room), min(standoff, max(0.0, room - standoff))
    need = owner.radius + follower.radius + _NEED + mine + theirs
    span = _closest(owner, follower, ahead, begin, end)
    if _length(span) < need:
        span = _closest(owner, follower, 0.0, 0.0, 0.0)
        if _length(span) < need:
            return _halfway(span, owner.radius, follower.radius)
        low, high = 0.0, 1.0
        for _ in range(_BISECTIONS):
            middle = 0.5 * (low + high)
            longer = _closest(owner, follower, middle * ahead, middle * begin, middle * end)
            if _length(longer) < need:
                high = middle
            else:
                low, span = middle, longer
    (ax, ay), (bx, by) = span
    length = _length(span)
    nx, ny = (bx - ax) / length, (by - ay) / length
    edge = nx * ax + ny * ay + owner.radius + 0.5 * _NEED + mine
    return Line(nx, ny, edge + share * (length - need))


def _halfway(span: Span, mine: float, theirs: float) -> Line | None:
    """The line in the middle of a gap that is narrower than what lines take, between disks of these radii,
    m; None if nothing is left. Two may come to stand as near as that, one beside the disk that the other was.
    """
    (ax, ay), (bx, by) = span
    length = _length(span)
    gap = length - mine - theirs
    if gap < 2.0 * SURE:
        return None
    nx, ny = (bx - ax) / length, (by - ay) / length
    return Line(nx, ny, nx * ax + ny * ay + mine + 0.5 * gap)


def _length(span: Span) -> float:
    return math.hypot(span[1][0] - span[0][0], span[1][1] - span[0][1])


def _closest(one: Disk, other: Disk, ahead: float, begin: float, end: float) -> Span:
    """Closest points of the paths that the two centres take, as of `fit_line`."""
    px, py, ux, uy = one.x, one.y, one.vx * ahead, one.vy * ahead
    qx, qy = other.x + other.ux * begin, other.y + other.uy * begin
    vx, vy = other.vx * end - other.ux * begin, other.vy * end - other.uy * begin
    wx, wy = qx - px, qy - py
    cross = ux * vy - uy * vx
    if cross != 0.0:
        s, t = (wx * vy - wy * vx) / cross, (wx * uy - wy * ux) / cross
        if 0.0 <= s <= 1.0 and 0.0 <= t <= 1.0:
            point = (px + s * ux, py + s * uy)
            return point, point
    uu, vv = ux * ux + uy * uy, vx * vx + vy * vy
    shortest, nearest = math.inf, ((px, py), (qx, qy))
    for s, t in (
        (_clamped(wx * ux + wy * uy, uu), 0.0),
        (_clamped((wx + vx) * ux + (wy + vy) * uy, uu), 1.0),
        (0.0, _clamped(-wx * vx - wy * vy, vv)),
        (1.0, _clamped((ux - wx) * vx + (uy - wy) * vy, vv)),
    ):
        span = ((px + s * ux, py + s * uy), (qx + t * vx, qy + t * vy))
        length = _length(span)
        if length < shortest:
            shortest, nearest = length, span
    return nearest


def _clamped(part: float, whole: float) -> float:
    """part / whole, kept within 0 and 1."""
    if part <= 0.0:
        return 0.0
    return 1.0 if part >= whole else part / whole
