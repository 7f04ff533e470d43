"""Which places obstacles separate, against flood filling."""

from random import Random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import ndimage

from agents.law.passages import gaps
from deploy.theory.surrounded import separating
from protocol.geometry import ConvexPolygon, Disk, Shape
from tests.protocol.shapes import SIZE, shapes

CELLS = 60
ROOMS = (
    Disk(0.0, 0.0, SIZE),
    ConvexPolygon([(-SIZE, -SIZE), (SIZE, -SIZE), (SIZE, 0.9 * SIZE), (-0.9 * SIZE, SIZE)]),
)


@pytest.mark.slow
@given(
    st.sampled_from(ROOMS),
    st.lists(shapes, min_size=1, max_size=11),
    st.floats(0.006, 0.045),
    st.randoms(use_true_random=False),
)
def test_a_chain_of_gaps_separates_what_flood_filling_separates(
    room: Shape, obstacles: list[Shape], radius: float, draw: Random
) -> None:
    cell, places = 2.0 * SIZE / CELLS, np.linspace(-SIZE, SIZE, CELLS)
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
