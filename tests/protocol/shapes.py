"""Disks and convex polygons for tests with hypothesis."""

import math
from itertools import pairwise

from hypothesis import strategies as st

from protocol.geometry import ConvexPolygon, Disk

SIZE = 0.3  # m, of the square that they are drawn in
coordinates = st.floats(-SIZE, SIZE)
points = st.tuples(coordinates, coordinates)
disks = st.builds(Disk, coordinates, coordinates, st.floats(0.005, 0.15))


def _winds(angles: list[int]) -> bool:
    """Whether steps of 10 degrees go round the centre, which is then inside."""
    ends = [*sorted(angles), min(angles) + 36]
    return all(after - before < 18 for before, after in pairwise(ends))


@st.composite
def polygons(draw: st.DrawFn) -> ConvexPolygon:
    """Corners on a stretched and turned circle: convex, in either sense."""
    angles = draw(st.lists(st.integers(0, 35), min_size=3, max_size=8, unique=True).filter(_winds))
    x, y = draw(points)
    long, wide, turn = draw(st.floats(0.01, 0.2)), draw(st.floats(0.002, 0.2)), draw(st.floats(0.0, math.tau))
    corners = []
    for angle in sorted(angles, reverse=draw(st.booleans())):
        u, v = long * math.cos(math.tau * angle / 36), wide * math.sin(math.tau * angle / 36)
        corners.append(
            (x + math.cos(turn) * u - math.sin(turn) * v, y + math.sin(turn) * u + math.cos(turn) * v)
        )
    return ConvexPolygon(corners)


shapes = st.one_of(disks, polygons())
