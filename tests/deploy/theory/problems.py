"""Problems on which the navigation function is tested: 2, 3 and 6 robots, equal and unequal radii."""

from __future__ import annotations

import numpy as np

from deploy.theory.exact_flow import random_configuration
from deploy.theory.function import Array, FleetProblem
from protocol.draws import Purpose, generator

SIZES = (2, 3, 6)


def free(problem: FleetProblem, seed: int) -> Array:
    """A random configuration in the interior of free space."""
    b = random_configuration(generator(seed, Purpose.STUDY), problem.radii, problem.workspace)
    assert b is not None
    return b


def crowded(p: int, unequal: bool, k: float, seed: int = 0) -> FleetProblem:
    """Random goals for p robots of radius 4, or 3 to 5, in a workspace of radius 30."""
    radii = np.linspace(3.0, 5.0, p) if unequal else np.full(p, 4.0)
    goals = random_configuration(generator(seed, Purpose.SCENARIO), radii, 30.0)
    assert goals is not None
    return FleetProblem(goals, radii, 30.0, k)


def admissible(p: int, unequal: bool, k: float) -> FleetProblem:
    """Goals on a wide circle in a wide workspace: Assumptions 1 and 2 hold."""
    circle, workspace = {2: (20.0, 60.0), 3: (30.0, 90.0), 6: (170.0, 320.0)}[p]
    radii = np.linspace(3.6, 4.4, p) if unequal else np.full(p, 4.0)
    angle = 2.0 * np.pi * np.arange(p) / p + 0.1
    return FleetProblem(circle * np.stack([np.cos(angle), np.sin(angle)], axis=1), radii, workspace, k)
