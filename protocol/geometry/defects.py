"""Why a list of corners is no convex polygon."""

from __future__ import annotations

import math
from collections.abc import Sequence

from protocol.geometry.polygon import Point, signed_area

_SHORT = 1e-9  # m, the least length of a side: its direction must be more than rounding
_STRAIGHT = 1e-9  # sine of a turn below which a corner is taken for a point of a straight side
_THIN = 1e-6  # of its length, that a polygon must be wide: it has two faces


def defect(points: Sequence[Point]) -> str:
    """What is wrong with a polygon's corners, "" if nothing; they may run in either sense."""
    count = len(points)
    if count < 3:
        return "needs three points at least"
    edges = [_difference(points[(n + 1) % count], points[n]) for n in range(count)]
    for n, edge in enumerate(edges):
        if math.hypot(*edge) < _SHORT:
            return f"points {n} and {(n + 1) % count} are the same, or nearly"
    sense = 1.0 if signed_area(points) > 0.0 else -1.0
    inward = [n for n in range(count) if sense * _turn(edges[n - 1], edges[n]) < -_STRAIGHT]
    once = abs(abs(math.fsum(_angle(edges[n - 1], edges[n]) for n in range(count))) - math.tau) < 1.0
    if (inward or not once) and (crossing := _crossing(points)):
        return f"crosses itself: the side from point {crossing[0]} meets the side from point {crossing[1]}"
    longest = max(math.hypot(*edge) for edge in edges)
    if abs(signed_area(points)) < _THIN * longest * longest:
        return "has no area"
    if inward:
        return f"is not convex at point {inward[0]}"
    return "" if once else "goes around more than once"


def _difference(one: Point, other: Point) -> Point:
    return one[0] - other[0], one[1] - other[1]


def _turn(one: Point, other: Point) -> float:
    """Sine of the angle from one edge to the next; a turn back is one inward."""
    cross = one[0] * other[1] - one[1] * other[0]
    along = one[0] * other[0] + one[1] * other[1]
    if along < 0.0 and abs(cross) <= _STRAIGHT * -along:
        return -math.inf
    return cross / (math.hypot(*one) * math.hypot(*other))


def _angle(one: Point, other: Point) -> float:
    """From one edge to the next, rad."""
    return math.atan2(one[0] * other[1] - one[1] * other[0], one[0] * other[0] + one[1] * other[1])


def _crossing(points: Sequence[Point]) -> tuple[int, int] | None:
    """Two sides that are not neighbours and have a point in common."""
    count = len(points)
    for i in range(count):
        for j in range(i + 2, count):
            if (j + 1) % count != i and _meet(points[i], points[i + 1], points[j], points[(j + 1) % count]):
                return i, j
    return None


def _meet(a: Point, b: Point, c: Point, d: Point) -> bool:
    """Whether two segments have a point in common."""
    one, other = (_left(a, b, c), _left(a, b, d)), (_left(c, d, a), _left(c, d, b))
    if one == (0, 0):  # on one line
        return _between(a, c, d) or _between(b, c, d) or _between(c, a, b)
    return one[0] * one[1] <= 0 and other[0] * other[1] <= 0


def _left(a: Point, b: Point, c: Point) -> int:
    """1 where c is to the left of the line from a to b, -1 to the right, 0 on it."""
    cross = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    return (cross > 0.0) - (cross < 0.0)


def _between(point: Point, one: Point, other: Point) -> bool:
    """Whether a point of the line through two others lies between them."""
    return all(min(a, b) <= p <= max(a, b) for p, a, b in zip(point, one, other, strict=True))
