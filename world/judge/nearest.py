"""Gaps of a large fleet: only of pairs that can be the nearest, or touch; the rest is surely further apart.

A pair with a gap of more than REACH has one of more than REACH less twice what anybody has moved since. If
the smallest gap that was measured is below that, it is the smallest of all, and no other pair touches.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from world.close_pairs import close_pairs
from world.judge.clearance import Disks, Plane, Reals, gaps

REACH: Final = 12.0  # mean radii
FEW: Final = 1 << 14  # pairs up to which all are measured
_ROUNDING: Final = 1e-6  # of the reach


class NearestGaps:
    """Measures gaps as `clearance.gaps` does, of fewer pairs where there are many.

    Args:
        disks: all of them.
    """

    def __init__(self, disks: Disks) -> None:
        self._all = self._near = disks
        self._reach = REACH * float(disks.surroundings.radii.mean())
        self._places: Plane | None = None  # where the disks were when it was looked who is near

    def __call__(self, before: Plane, after: Plane) -> tuple[Disks, Reals]:
        """Gaps of n motions, shape (n, p) each, among them the smallest of each and all that are negative;
        and the disks with these pairs.
        """
        everybody = self._all
        if len(everybody.contact) <= FEW:
            return everybody, gaps(everybody, before, after)
        beyond = self._beyond(before, after)
        if beyond < 0.5 * self._reach:
            self._look(before[0])
            beyond = self._beyond(before, after)
        self._near.surroundings = everybody.surroundings
        found = gaps(self._near, before, after)
        if beyond >= 0.0 and (found.min(axis=-1) <= beyond).all():
            return self._near, found
        return everybody, gaps(everybody, before, after)

    def _beyond(self, before: Plane, after: Plane) -> float:
        """What the gap of every other pair surely exceeds, m."""
        if self._places is None:
            return -np.inf
        moved = max(float(np.abs(plane - self._places).max()) for plane in (before, after))
        return (1.0 - _ROUNDING) * self._reach - 2.0 * moved

    def _look(self, places: Plane) -> None:
        """Look who is near whom."""
        self._places = places.copy()
        self._near = self._all.only(*close_pairs(places, self._all.surroundings.radii, self._reach))
