"""A sweep finds the pairs that a look at all of them finds."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st

from world.judge.clearance import close_pairs

coordinate = st.floats(-2.0, 2.0) | st.sampled_from([0.0, 0.5, 1.0])
disk = st.tuples(st.builds(complex, coordinate, coordinate), st.floats(0.01, 0.5))


@given(st.lists(disk, max_size=12), st.floats(0.0, 1.0))
@example([(0j, 0.25), (1.5 + 0j, 0.25)], 1.0)
@example([(1j * n, 0.1) for n in range(5)], 0.8)
def test_every_close_pair_and_no_other_is_found(disks: list[tuple[complex, float]], reach: float) -> None:
    places = np.array([place for place, _ in disks], dtype=np.complex128)
    radii = np.array([radius for _, radius in disks], dtype=np.float64)
    first, second = close_pairs(places, radii, reach)
    wanted = [
        (i, j)
        for i, j in combinations(range(len(disks)), 2)
        if np.abs(places[i] - places[j]) - (radii[i] + radii[j]) <= reach
    ]
    assert list(zip(first.tolist(), second.tolist(), strict=True)) == wanted
