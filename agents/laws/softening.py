"""A softer repulsion near the goal, once States are late.

The repulsive layer around a disk is about gamma/k thin. Near the goals gamma is small, and the layer is
thinner than the way of a peer before its State arrives: robots come so close that each has to wait until it
sees the other leave, and lines give them no more speed than gap over latency. A smaller k keeps them farther
apart, for a path that is a little longer. Far from the goals it would only widen detours.
"""

from __future__ import annotations

from typing import Final

SOFTER: Final = 0.7  # k is divided by one plus this, for States that are a lap late
LATEST: Final = 1.0  # laps, beyond which later States make nothing softer
WHOLLY: Final = 1.5  # radii from the goal, within which that holds in full
AT_ALL: Final = 3.5  # radii from the goal, from which on nothing is softer


def softened(k: float, away: float, latency: float) -> float:
    """The exponent k for a robot `away` (own radii) from its goal, if the oldest State that it uses is
    `latency` laps old. In a lap the largest disk moves by its radius at full speed."""
    near = min(1.0, max(0.0, (AT_ALL - away) / (AT_ALL - WHOLLY)))
    return k / (1.0 + SOFTER * near * min(latency, LATEST))
