"""The rule behind k = "auto"; the data behind the rule are in docs/theory/auto-k.md."""

from __future__ import annotations

import math

import numpy as np

from deploy.theory.doors import RESERVE, doors
from deploy.theory.function import Array
from protocol.geometry import Disk, Shape
from protocol.scenario.model import Scenario

PAPER_K = 60.0  # the gain of the paper's six robots (section 4)
PAPER_ROBOTS = 6.0
SPARSE = 0.15  # density up to which the number of robots alone decides


def density(radii: Array, workspace: float) -> float:
    """Area of the disks over area of the workspace."""
    return float((np.asarray(radii) ** 2).sum() / workspace**2)


def gain_for(scenario: Scenario) -> float:
    """The k that "auto" stands for: that of the crowd, or what the narrowest doors on the ways need."""
    k = automatic_k(*crowd(scenario))
    return max([k, *(RESERVE * door.gain for door in doors(scenario, k / RESERVE))])


def crowd(scenario: Scenario) -> tuple[Array, float]:
    """Radii of everything that is in the way, robots first, and of the workspace, m, as `automatic_k` takes
    them; what is not round counts by its area."""
    things = [_round(shape) for shape in scenario.shapes.values()]
    radii = np.array([*(robot.radius for robot in scenario.robots), *things])
    return radii, _round(scenario.workspace.shape)


def _round(shape: Shape) -> float:
    return shape.radius if isinstance(shape, Disk) else math.sqrt(shape.area / math.pi)


def automatic_k(radii: Array, workspace: float) -> float:
    """A gain k at which p robots of these radii (m) arrive in a workspace of this radius (m).

    60 max(1, (p / 6)^2, (density / 0.15)^2). gamma is a sum over robots, so the repulsive layer gamma / k
    must be thinned as they grow in number; few robots in a crowded workspace need narrow gaps to be open.
    Neither bound of Theorem 1 is used: where it exists it is many orders of magnitude larger.
    """
    crowd = max(1.0, len(radii) / PAPER_ROBOTS, density(radii, workspace) / SPARSE)
    return PAPER_K * crowd**2
