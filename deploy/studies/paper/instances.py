"""Random instances of the coordinated navigation problem: radii, goals and start at a given density."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from deploy.theory.function import Problem
from deploy.theory.gain.tuning import automatic_k
from deploy.theory.sampling import random_configuration
from protocol.errors import UsageError

Array = NDArray[np.float64]


def random_radii(draw: np.random.Generator, p: int, ratio: float) -> Array:
    """(p,) radii, log-uniform between 1 and `ratio`, largest first."""
    return np.asarray(np.sort(ratio ** draw.uniform(0.0, 1.0, p))[::-1])


def random_instance(draw: np.random.Generator, p: int, density: float, ratio: float) -> tuple[Problem, Array]:
    """A problem, its k set by the automatic rule, and a start (p, 2).

    density: area of the disks over area of the workspace; ratio: largest over smallest possible radius.

    Raises:
        UsageError: no free configuration was found at this density.
    """
    radii = random_radii(draw, p, ratio)
    workspace = float(np.sqrt((radii**2).sum() / density))
    goals = random_configuration(draw, radii, workspace)
    start = random_configuration(draw, radii, workspace)
    if goals is None or start is None:
        raise UsageError(f"no free configuration of {p} disks found at density {density:g}; use a lower one")
    return Problem(goals, radii, workspace, automatic_k(radii, workspace)), start
