"""Whether disks overlapped each other, an obstacle or the wall while all robots moved straight for a tick."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from protocol.geometry import Shape
from protocol.messages import Vector
from protocol.scenario.model import Scenario

TOLERANCE = 2e-9  # m


def overlap(
    scenario: Scenario, obstacles: Mapping[int, Shape], before: Sequence[Vector], after: Sequence[Vector]
) -> str:
    """Which disk overlapped what, and by how much; "" if none did. Places in the order of the ids, m."""
    ids = scenario.ids
    for number, robot in enumerate(ids):
        radius = scenario.spec(robot).radius
        outside = scenario.workspace.shape.distance(*after[number]) + radius
        if outside > TOLERANCE:
            return f"robot {robot} is out of the workspace by {outside:.3g} m"
        way = math.dist(before[number], after[number])
        for obstacle, shape in obstacles.items():
            if shape.distance(*after[number]) > radius + way:
                continue  # it was never nearer by more than its way
            excess = radius - _nearest(shape, before[number], after[number])
            if excess > TOLERANCE:
                return f"robot {robot} and obstacle {obstacle} overlap by {excess:.3g} m"
        for index in range(number):
            contact = radius + scenario.spec(ids[index]).radius
            excess = contact - _closest(before[number], before[index], after[number], after[index])
            if excess > TOLERANCE:
                return f"robots {ids[index]} and {robot} overlap by {excess:.3g} m"
    return ""


def _nearest(shape: Shape, before: Vector, after: Vector) -> float:
    """Smallest distance from a shape during straight motion, a convex function of time, m."""
    (ax, ay), (bx, by) = before, after
    low, high = 0.0, 1.0
    for _ in range(60):
        one, other = low + (high - low) / 3.0, high - (high - low) / 3.0
        near, far = (shape.distance(ax + t * (bx - ax), ay + t * (by - ay)) for t in (one, other))
        low, high = (low, other) if near < far else (one, high)
    return shape.distance(ax + low * (bx - ax), ay + low * (by - ay))


def _closest(one: Vector, other: Vector, one_after: Vector, other_after: Vector) -> float:
    """Smallest distance while both move straight, m."""
    px, py = one[0] - other[0], one[1] - other[1]
    vx, vy = one_after[0] - other_after[0] - px, one_after[1] - other_after[1] - py
    square = vx * vx + vy * vy
    when = 0.0 if square == 0.0 else min(1.0, max(0.0, -(px * vx + py * vy) / square))
    return math.hypot(px + when * vx, py + when * vy)
