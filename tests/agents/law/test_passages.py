"""Ways through gaps little wider than a disk."""

from itertools import pairwise

import numpy as np
import pytest

from agents.law.obstacles import Attraction
from protocol.geometry import ConvexPolygon, Disk


def tip(x: float, y: float) -> ConvexPolygon:
    """A needle that points up."""
    return ConvexPolygon([(x - 0.01, -1.0), (x + 0.01, -1.0), (x, y)])


@pytest.mark.parametrize("slack", [1e-3, 1e-2, 1e-1])
@pytest.mark.parametrize(
    "obstacles",
    [
        lambda width: [tip(0.0, 0.0), ConvexPolygon([(-0.5, width), (0.5, width), (0.5, 1.9), (-0.5, 1.9)])],
        lambda width: [Disk(0.0, -1.0, 1.0), Disk(0.0, width + 0.9, 0.9)],
        lambda width: [Disk(0.0, -1.0, 1.0), ConvexPolygon([(-0.3, 1.8), (0.3, 1.8), (0.0, width)])],
    ],
    ids=["tip and face", "disks", "disk and corner"],
)
def test_a_way_leads_through_a_gap_that_is_little_wider_than_the_disk(obstacles, slack: float) -> None:
    """Around a needle, for which corners stand at steps of a third of a half-turn, and between disks."""
    radius = 0.1
    width = 2.0 * radius * (1.0 + slack)
    room = ConvexPolygon([(-2.0, -1.05), (2.0, -1.05), (2.0, 1.95), (-2.0, 1.95)])
    obstacles = obstacles(width)
    start, goal = (-1.5, 0.3), (1.5, 0.3)
    way = [start, *Attraction(room, radius, alone=True).way(start, goal, obstacles)]
    assert way[-1] == goal
    for (ax, ay), (bx, by) in pairwise(way):
        for part in np.linspace(0.0, 1.0, 501):
            place = ax + part * (bx - ax), ay + part * (by - ay)
            assert min(shape.distance(*place) for shape in obstacles) >= radius
