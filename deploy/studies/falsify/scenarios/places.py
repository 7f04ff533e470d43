"""Where disks stand: anywhere, up to densities of 0.4, and closer together than chance would put them."""

from __future__ import annotations

import math
from collections.abc import Sequence

from deploy.studies.falsify.scenarios.dice import Dice
from protocol.scenario.model import Point

_DARTS = 40  # attempts per disk
_SWEEPS = 200  # of pushing disks apart that darts did not place
_ATTEMPTS = 20
_GAPS = (0.0, 0.0, 1e-9, 1e-6, 1e-3, 0.03)  # in radii; 0: the next number of the computer
_WHISKER = 1e-15  # by which an exact touch is left, at first


def scattered(dice: Dice, radii: Sequence[float], workspace: float) -> list[Point] | None:
    """Centres of disks in a workspace of this radius, all lengths in m; None if they found no room."""
    for _ in range(_ATTEMPTS):
        points = [anywhere(dice, workspace - radius) for radius in radii]
        for i in sorted(range(len(radii)), key=lambda i: -radii[i]):
            for _ in range(_DARTS):
                if fits(i, points, radii, workspace):
                    break
                points[i] = anywhere(dice, workspace - radii[i])
        if _pushed_apart(points, radii, workspace):
            return points
    return None


def fits(i: int, points: Sequence[Point], radii: Sequence[float], workspace: float) -> bool:
    """Whether disk i touches neither boundary nor another disk, computed as the scenario's checks do."""
    x, y = points[i]
    return math.hypot(x, y) + radii[i] < workspace and all(
        math.hypot(x - points[j][0], y - points[j][1]) > radii[i] + radii[j]
        for j in range(len(radii))
        if j != i
    )


def drawn_together(
    dice: Dice, points: Sequence[Point], radii: Sequence[float], workspace: float, times: int
) -> list[Point]:
    """The same disks with some of them, `times` at most, moved against another one or the boundary."""
    points = list(points)
    for _ in range(times):
        i, j = dice.whole(0, len(points) - 1), dice.whole(0, len(points) - 1)
        gap = dice.pick(_GAPS) * radii[i]
        moved = (
            at_the_wall(points[i], radii[i], workspace, gap)
            if i == j
            else beside(points[j], radii[j], points[i], radii[i], gap)
        )
        before, points[i] = points[i], moved
        if not fits(i, points, radii, workspace):
            points[i] = before
    return points


def at_the_wall(point: Point, radius: float, workspace: float, gap: float) -> Point:
    """The point in the same direction at which a disk has this gap to the boundary, and surely some."""
    length, angle = workspace - radius - gap, math.atan2(point[1], point[0])
    whisker = _WHISKER
    while True:
        at = (length * (1.0 - whisker) * math.cos(angle), length * (1.0 - whisker) * math.sin(angle))
        if math.hypot(*at) + radius < workspace:
            return at
        whisker *= 2.0


def beside(other: Point, other_radius: float, point: Point, radius: float, gap: float) -> Point:
    """The point in the same direction from `other` at which two disks have this gap, and surely some."""
    apart, angle = other_radius + radius, math.atan2(point[1] - other[1], point[0] - other[0])
    whisker = _WHISKER
    while True:
        length = (apart + gap) * (1.0 + whisker)
        at = (other[0] + length * math.cos(angle), other[1] + length * math.sin(angle))
        if math.hypot(at[0] - other[0], at[1] - other[1]) > apart:
            return at
        whisker *= 2.0


def anywhere(dice: Dice, reach: float) -> Point:
    """Uniform in a disk around the origin."""
    length, angle = reach * math.sqrt(dice.uniform(0.0, 1.0)), dice.uniform(-math.pi, math.pi)
    return length * math.cos(angle), length * math.sin(angle)


def _pushed_apart(points: list[Point], radii: Sequence[float], workspace: float) -> bool:
    """Move overlapping disks apart, in place, and whether none overlap at last."""
    for _ in range(_SWEEPS):
        stuck = [i for i in range(len(radii)) if not fits(i, points, radii, workspace)]
        if not stuck:
            return True
        for i in stuck:
            for j in range(len(radii)):
                if j != i:
                    points[i], points[j] = _parted(points[i], points[j], radii[i] + radii[j])
            for j in range(len(radii)):
                if math.hypot(*points[j]) + radii[j] >= workspace:
                    points[j] = at_the_wall(points[j], radii[j], workspace, 1e-6 * radii[j])
    return False


def _parted(one: Point, other: Point, apart: float) -> tuple[Point, Point]:
    """Two points moved away from each other, each as far, until they are this far apart."""
    dx, dy = other[0] - one[0], other[1] - one[1]
    distance = math.hypot(dx, dy)
    if distance > apart:
        return one, other
    if distance == 0.0:
        dx, distance = apart, apart
    push = 0.5 * (apart * (1.0 + 1e-4) - distance) / distance
    return (one[0] - push * dx, one[1] - push * dy), (other[0] + push * dx, other[1] + push * dy)
