"""The rule behind k = "auto"; the data behind the rule are in docs/auto-k.md."""

from __future__ import annotations

import numpy as np

from deploy.theory.function import Array

PAPER_K = 60.0  # the gain of the paper's six robots (section 4)
PAPER_ROBOTS = 6.0
SPARSE = 0.15  # density up to which the number of robots alone decides


def density(radii: Array, workspace: float) -> float:
    """Area of the disks over area of the workspace."""
    return float((np.asarray(radii) ** 2).sum() / workspace**2)


def automatic_k(radii: Array, workspace: float) -> float:
    """A gain k at which p robots of these radii (m) arrive in a workspace of this radius (m).

    60 max(1, (p / 6)^2, (density / 0.15)^2). gamma is a sum over robots, so the repulsive layer gamma / k
    must be thinned as they grow in number; few robots in a crowded workspace need narrow gaps to be open.
    Neither bound of Theorem 1 is used: where it exists it is many orders of magnitude larger.
    """
    crowd = max(1.0, len(radii) / PAPER_ROBOTS, density(radii, workspace) / SPARSE)
    return PAPER_K * crowd**2
