"""The initial lines of one founding life with all peers of whom nothing else is known.

In a large fleet that is nearly everybody: nobody is told these lines, or keeps an object for each. They
follow from starts and radii, and are looked at together, as often as somebody can have come near one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from agents.peers.far import FarPicture

Array = NDArray[np.float64]
Vector = tuple[float, float]

_ROUNDING: Final = 1e-6  # m, more than the same line computed one by one may differ by


@final
class InitialLines:
    """Each line lies in the middle of the gap between two disks at their starts (`placement.initial_line`).

    Args:
        robot: own id.
        starts: where every robot begins, m.
        radii: of every robot, m.
        ahead: way (m) that the own centre may go before lines are looked at again.
    """

    def __init__(
        self, robot: int, starts: Mapping[int, Vector], radii: Mapping[int, float], ahead: float = 0.0
    ) -> None:
        self._robot, self._ahead = robot, ahead
        self._looked_x = self._looked_y = 0.0
        self._looked = -1.0  # gap (m) up to which lines were looked at there
        self._peers = np.array(sorted(peer for peer in starts if peer != robot), dtype=np.int64)
        ids = self._peers.tolist()
        there: Array = np.array([starts[peer] for peer in ids], dtype=np.float64).reshape(-1, 2)
        between = there - np.asarray(starts[robot])
        length = np.sqrt((between**2).sum(axis=1))
        self._normals: Array = between / np.maximum(length, 1e-12)[:, None]  # away from this robot
        gap: Array = length - radii[robot] - np.array([radii[peer] for peer in ids])
        self._limits: Array = self._normals @ np.asarray(starts[robot]) + 0.5 * gap  # of the own centre
        self._theirs: Array = (self._normals * there).sum(axis=1) - 0.5 * gap  # of the peers' centres
        self._gaps = gap

    def __len__(self) -> int:
        return len(self._peers)

    @property
    def unusable(self) -> list[int]:
        """Peers with whom there may be no line, for they may touch."""
        ids: list[int] = self._peers[self._gaps < _ROUNDING].tolist()
        return ids

    def approached(self, x: float, y: float, reach: float) -> list[int]:
        """Every peer whose line may be less than `reach` (m) from the own centre at (x, y), m, and some more.
        None is looked for as long as the centre has not moved by what the others were farther off."""
        if not len(self._peers):
            return []
        if math.hypot(x - self._looked_x, y - self._looked_y) + reach <= self._looked:
            return []
        self._looked_x, self._looked_y, self._looked = x, y, reach + self._ahead
        return self.within(x, y, self._looked)

    def within(self, x: float, y: float, reach: float) -> list[int]:
        """Every peer whose line may be less than `reach` (m) from the own disk if that is at (x, y), m."""
        slack = self._limits - self._normals @ np.array((x, y))
        ids: list[int] = self._peers[slack < reach + _ROUNDING].tolist()
        return ids

    def reached(self, picture: FarPicture, reach: float) -> list[int]:
        """Every peer that this robot owns the line with and that was less than `reach` (m) from it."""
        first = int(np.searchsorted(self._peers, self._robot))
        peers, normals, theirs = self._peers[first:], self._normals[first:], self._theirs[first:]
        if not len(peers) or not len(picture.robots):
            return []
        index = np.minimum(np.searchsorted(picture.robots, peers), len(picture.robots) - 1)
        places = picture.places[index]
        slack = normals[:, 0] * places[:, 0] + normals[:, 1] * places[:, 1] - theirs
        found = (slack < reach + _ROUNDING) & (picture.robots[index] == peers)
        ids: list[int] = peers[found].tolist()
        return ids

    def leave(self, peer: int) -> None:
        """More is known of this peer: look at its line no more."""
        index = int(np.searchsorted(self._peers, peer))
        if index < len(self._peers) and self._peers[index] == peer:
            self._gaps[index] = self._limits[index] = np.inf  # farther than any reach
            self._theirs[index] = -np.inf
