"""The eps that proves most: the smallest K over all eps at which the assumptions hold."""

from __future__ import annotations

import numpy as np

from deploy.theory.function import Problem
from deploy.theory.gain.assumptions import largest_eps
from deploy.theory.gain.bounds import Bounds, bounds
from deploy.theory.gain.families import family


def best_bounds(problem: Problem) -> Bounds | None:
    """Bounds at the best eps, to a part in a thousand or so; None when the assumptions fail for every eps.

    K falls like 1/eps^2 for small eps and grows without limit where a margin vanishes.
    """
    clusters = family(problem)
    limit = largest_eps(problem, clusters)
    if limit is None:
        return None
    low, high = 1e-6, 1.0 - 1e-6
    best: Bounds | None = None
    for _ in range(3):  # zoom in on the best of a grid, three times
        grid = limit * np.linspace(low, high, 40)
        tried = [bounds(problem, float(eps), clusters) for eps in grid]
        found = [entry for entry in tried if entry is not None]
        if not found:
            return best
        best = min(found, key=lambda entry: entry.polar)
        at, width = best.eps / limit, (high - low) / 39.0
        low, high = max(at - width, 1e-6), min(at + width, 1.0 - 1e-6)
    return best
