"""The eps that proves most: the smallest K over all eps at which the assumptions hold."""

from __future__ import annotations

from math import inf

from scipy.optimize import minimize_scalar

from deploy.theory.function import Problem
from deploy.theory.gain.assumptions import largest_eps
from deploy.theory.gain.bounds import Bounds, bounds
from deploy.theory.gain.families import family


def best_bounds(problem: Problem) -> Bounds | None:
    """Bounds at the best eps; None when the assumptions fail for every eps.

    K falls like 1/eps^2 for small eps and grows without limit where a margin vanishes.
    """
    clusters = family(problem)
    limit = largest_eps(problem, clusters)
    if limit is None:
        return None

    def polar(eps: float) -> float:
        found = bounds(problem, eps, clusters)
        return inf if found is None else found.polar

    best = minimize_scalar(polar, bounds=(0.0, limit), method="bounded", options={"xatol": 1e-6 * limit})
    return bounds(problem, float(best.x), clusters)
