"""The rule behind k = "auto"."""

from __future__ import annotations

from agents.navigation.function import Array


def automatic_k(radii: Array, workspace: float) -> float:
    """A gain k that lets p robots of these radii (m) arrive in a workspace of this radius (m).

    gamma is a sum over robots, so the repulsive layer gamma / k must be divided among more of them.
    """
    del workspace
    return max(60.0, 60.0 * (len(radii) / 6.0) ** 2)
