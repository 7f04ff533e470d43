"""The gain k of a fleet that has grown beyond what its scenario was written for."""

from __future__ import annotations


def grown(k: float, robots: int, present: int) -> float:
    """The gain for `present` robots, if `k` is that for `robots`.

    gamma is a sum over robots, so the repulsive layer gamma / k must be thinned as they grow in number: by
    the square of it, as the rule behind k = "auto" says. A fleet that shrinks keeps its gain.
    """
    return k if present <= robots else k * (present / robots) ** 2
