"""Places that obstacles separate for a disk.

For the centre of a disk, obstacles are inflated by its radius. Start and goal lie in different parts of free
space exactly if a closed chain of overlapping inflated obstacles, the outside of the workspace among them,
runs between the two: inflated obstacles are convex, so chains represent every closed curve in their union,
and a plane set separates two points exactly if a closed curve in it does (Alexander duality): if it crosses
the straight way from one to the other an odd number of times.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from scipy.cluster.hierarchy import DisjointSet

from agents.law.passages import OUTSIDE, Gap, crosses
from protocol.geometry import Disk, Shape
from protocol.messages import Vector


def separating(obstacles: Sequence[Shape], closed: Sequence[Gap], start: Vector, goal: Vector) -> Gap | None:
    """The gap that, after those before it, closes the last path from start to goal; None if a path remains.

    Args:
        obstacles: as indexed by the gaps.
        closed: gaps that are too narrow, in the order in which they close.
        start, goal: places that keep clear of all obstacles, m.
    """
    outside = len(obstacles)
    halves = DisjointSet(range(2 * outside + 2))  # of each obstacle; a crossing joins unlike ones
    centres = [_inside(shape) for shape in obstacles]
    for gap in closed:
        chain = [centres[gap.one], gap.begin, gap.end]
        chain += [centres[gap.other]] if gap.other != OUTSIDE else []
        crossed = sum(crosses(a, b, start, goal) for a, b in pairwise(chain))
        other = outside if gap.other == OUTSIDE else gap.other
        for half in (0, 1):
            halves.merge(2 * gap.one + half, 2 * other + (half + crossed) % 2)
        if halves.connected(2 * gap.one, 2 * gap.one + 1):
            return gap
    return None


def _inside(shape: Shape) -> Vector:
    """A point of an obstacle, m."""
    if isinstance(shape, Disk):
        return shape.x, shape.y
    count = len(shape.points)
    return math.fsum(x for x, _ in shape.points) / count, math.fsum(y for _, y in shape.points) / count
