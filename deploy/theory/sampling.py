"""Random free configurations of disks in a disk."""

from __future__ import annotations

import numpy as np

from deploy.theory.function import Array

DARTS = 500
ATTEMPTS = 2000


def random_configuration(draw: np.random.Generator, radii: Array, workspace: float) -> Array | None:
    """(p, 2) centres of disjoint disks, by dart throwing, largest first; None when no free one was found.

    Starts again when a disk finds no place.
    """
    order = np.argsort(-radii, kind="stable")
    for _ in range(ATTEMPTS):
        placed = _throw(draw, radii[order], workspace)
        if placed is not None:
            out = np.empty_like(placed)
            out[order] = placed
            return out
    return None


def _throw(draw: np.random.Generator, radii: Array, workspace: float) -> Array | None:
    placed = np.empty((0, 2))
    for i, radius in enumerate(radii):
        darts = draw.uniform(-workspace, workspace, (DARTS, 2))
        inside = np.hypot(*darts.T) < workspace - radius
        gaps = np.linalg.norm(darts[:, None] - placed[None], axis=2) - radius - radii[:i]
        free = np.flatnonzero(inside & (gaps > 0.0).all(axis=1))
        if not len(free):
            return None
        placed = np.vstack([placed, darts[free[0]]])
    return placed
