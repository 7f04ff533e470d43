"""Which disks are close to each other, without a look at every pair."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Reals = NDArray[np.float64]
Plane = NDArray[np.complex128]
Indices = NDArray[np.intp]


def close_pairs(places: Plane, radii: Reals, reach: float) -> tuple[Indices, Indices]:
    """All pairs whose gap is at most `reach`: indices i < j, in the order of a triangle's rows.

    Only pairs close in x are examined: a sweep along that axis.

    Args:
        places: centres x + iy, shape (p,), m.
        radii: shape (p,), m.
        reach: m, at least 0.
    """
    order = np.argsort(places.real, kind="stable")
    x = places.real[order]
    widest = 2.0 * float(radii.max(initial=0.0)) + reach
    behind = np.arange(1, len(x) + 1)
    counts = np.maximum(np.searchsorted(x, x + widest * (1.0 + 1e-9), side="right") - behind, 0)
    one = np.repeat(np.arange(len(x)), counts)
    other = np.arange(len(one)) - np.repeat(np.cumsum(counts) - counts, counts) + behind[one]
    first, second = np.minimum(order[one], order[other]), np.maximum(order[one], order[other])
    close = np.abs(places[first] - places[second]) - (radii[first] + radii[second]) <= reach
    first, second = first[close], second[close]
    rows = np.lexsort((second, first))
    return first[rows], second[rows]
