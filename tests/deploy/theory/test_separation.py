"""Which places obstacles separate, against flood filling."""

import math
import random

import numpy as np
import pytest
from scipy import ndimage

from agents.law.passages import gaps
from deploy.theory.separation import separating
from protocol.geometry import ConvexPolygon, Disk, Shape

CELLS = 60
ROOMS = (Disk(0.0, 0.0, 1.0), ConvexPolygon([(-1.0, -1.0), (1.0, -1.0), (1.0, 0.9), (-0.9, 1.0)]))


def polygon(draw: random.Random) -> ConvexPolygon:
    """Of three to five corners on an ellipse, which may be long and thin."""
    count = draw.choice((3, 4, 5))
    turns = [math.tau * (n + draw.uniform(0.1, 0.9)) / count for n in range(count)]
    centre, turn = complex(draw.uniform(-1, 1), draw.uniform(-1, 1)), draw.uniform(0.0, math.tau)
    length, width = draw.uniform(0.1, 0.8), draw.uniform(0.02, 0.5)
    corners = [centre + np.exp(1j * turn) * complex(length * math.cos(t), width * math.sin(t)) for t in turns]
    return ConvexPolygon([(z.real, z.imag) for z in corners])


def disk(draw: random.Random) -> Disk:
    return Disk(draw.uniform(-1, 1), draw.uniform(-1, 1), draw.uniform(0.02, 0.25))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_a_chain_of_gaps_separates_what_flood_filling_separates(seed: int) -> None:
    draw = random.Random(seed)
    room = ROOMS[seed % 2]
    obstacles: list[Shape] = [
        polygon(draw) if draw.random() < 0.7 else disk(draw) for _ in range(draw.randrange(1, 12))
    ]
    radius, cell = draw.uniform(0.02, 0.15), 2.0 / CELLS
    places = np.linspace(-1.0, 1.0, CELLS)
    clearance = np.array(
        [
            [min(-room.distance(x, y), *(shape.distance(x, y) for shape in obstacles)) for x in places]
            for y in places
        ]
    )
    surely, _ = ndimage.label(clearance >= radius + cell)
    perhaps, _ = ndimage.label(clearance >= radius - cell)
    free = np.argwhere(surely)
    closed = gaps(room, obstacles, 2.0 * radius)
    for _ in range(50 if len(free) else 0):
        a, b = (tuple(free[draw.randrange(len(free))]) for _ in "ab")
        start, goal = (places[a[1]], places[a[0]]), (places[b[1]], places[b[0]])
        if surely[a] == surely[b]:
            assert separating(obstacles, closed, start, goal) is None
        elif perhaps[a] != perhaps[b]:
            assert separating(obstacles, closed, start, goal) in closed


def test_the_gap_that_closes_the_last_way_is_the_narrowest_of_the_widest_one() -> None:
    room = ConvexPolygon([(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)])
    wall = [(0.0, 1.0), (1.4, 2.0), (2.6, 4.0)]  # doors of 0.4 m and 0.6 m
    obstacles = [ConvexPolygon([(2.0, a), (2.1, a), (2.1, b), (2.0, b)]) for a, b in wall]
    ends = (1.0, 1.0), (3.0, 3.0)
    assert separating(obstacles, gaps(room, obstacles, 0.59), *ends) is None
    last = separating(obstacles, gaps(room, obstacles, 0.61), *ends)
    assert last.width == pytest.approx(0.6)
    assert separating(obstacles, gaps(room, obstacles, 0.61), ends[0], (1.0, 3.0)) is None
