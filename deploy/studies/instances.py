"""Random free configurations of disks in a disk, for studies of the flow."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from agents.navigation.function import Problem

Array = NDArray[np.float64]


def random_radii(draw: np.random.Generator, p: int, ratio: float) -> Array:
    """(p,) radii, log-uniform between 1 and `ratio`, largest first."""
    return np.asarray(np.sort(ratio ** draw.uniform(0.0, 1.0, p))[::-1])


def random_configuration(draw: np.random.Generator, radii: Array, workspace: float) -> Array:
    """(p, 2) centres of disjoint disks, by dart throwing; starts again when a disk finds no place."""
    while True:
        placed = np.empty((0, 2))
        for i, radius in enumerate(radii):
            darts = draw.uniform(-workspace, workspace, (500, 2))
            inside = np.hypot(*darts.T) < workspace - radius
            gaps = np.linalg.norm(darts[:, None] - placed[None], axis=2) - radius - radii[:i]
            free = np.flatnonzero(inside & (gaps > 0.0).all(axis=1))
            if not len(free):
                break
            placed = np.vstack([placed, darts[free[0]]])
        else:
            return placed


def random_instance(
    draw: np.random.Generator, p: int, density: float, ratio: float, k: float
) -> tuple[Problem, Array]:
    """A problem with random goals, and a random start; `density` is area of disks over area of workspace."""
    radii = random_radii(draw, p, ratio)
    workspace = float(np.sqrt((radii**2).sum() / density))
    goals = random_configuration(draw, radii, workspace)
    start = random_configuration(draw, radii, workspace)
    return Problem(goals, radii, workspace, k), start
