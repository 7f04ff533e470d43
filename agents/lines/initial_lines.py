"""The lines of one founding life about which nothing is open, with peers that are far from them.

In a large fleet that is nearly all of them: the initial ones, which follow from starts and radii, so that
nobody is told them, or keeps an object for each; and those that were agreed on later and left behind. They
are looked at together, as often as somebody can have come near one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from agents.lines.line import HalfPlane
from agents.peers.far import FarPicture, Places, shift

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Vector = tuple[float, float]

_ROUNDING: Final = 1e-6  # m, more than the same line computed one by one may differ by


@final
class InitialLines:
    """Each line lies in the middle of the gap between two disks at their starts (`placement.initial_line`),
    until another one is put to rest.

    Args:
        robot: own id.
        starts: where every robot begins, m.
        radii: of every robot, m.
        ahead: way (m) that the own centre, or a peer, may go before all lines are looked at again.

    Attributes:
        unusable: peers with whom there may be no line, for they may touch.
        moved_on: whether lines may rest now that were too near when `rest` was last tried; whoever tries all
            of them again takes it back.
    """

    def __init__(
        self, robot: int, starts: Mapping[int, Vector], radii: Mapping[int, float], ahead: float = 0.0
    ) -> None:
        self._robot, self._ahead = robot, ahead
        self.moved_on = False
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
        self.unusable: list[int] = self._peers[gap < _ROUNDING].tolist()
        self._owned = int(np.searchsorted(self._peers, robot))  # from there on, the lines are this robot's
        self._watched: Places | None = None  # by which it was looked which peers may reach a line,
        self._within = 0.0  # m,
        self._rows = self._peers[:0]  # and found these lines,
        self._there = self._rows  # and where the summary has their peers

    def __len__(self) -> int:
        return len(self._peers)

    def approached(self, x: float, y: float, reach: float) -> list[int]:
        """Every peer whose line may be less than `reach` (m) from the own centre at (x, y), m, and some more.
        None is looked for as long as the centre has not moved by what the others were farther off."""
        if not len(self._peers):
            return []
        if math.hypot(x - self._looked_x, y - self._looked_y) + reach <= self._looked:
            return []
        self._looked_x, self._looked_y, self._looked = x, y, reach + self._ahead
        self.moved_on = True
        return self.within(x, y, self._looked)

    def within(self, x: float, y: float, reach: float) -> list[int]:
        """Every peer whose line may be less than `reach` (m) from the own disk if that is at (x, y), m."""
        slack = self._limits - self._normals @ np.array((x, y))
        ids: list[int] = self._peers[slack < reach + _ROUNDING].tolist()
        return ids

    def reached(self, picture: FarPicture, reach: float) -> list[int]:
        """Every peer that this robot owns the line with and that was less than `reach` (m) from it."""
        said = picture.said
        if self._watched is None or shift(self._watched, said) + reach > self._within:
            self._watch(said, reach + self._ahead)
        rows = self._rows
        ids: list[int] = self._peers[rows[self._slack(rows, self._there, said) < reach + _ROUNDING]].tolist()
        return ids

    def _watch(self, said: Places, within: float) -> None:
        """Note which peers of own lines were less than `within` (m) from it: the others have to go that far
        before they can reach it."""
        self._watched, self._within, self.moved_on = said, within, True
        rows = np.arange(self._owned if len(said.robots) else len(self._peers), len(self._peers))
        there = np.minimum(np.searchsorted(said.robots, self._peers[rows]), len(said.robots) - 1)
        close = (said.robots[there] == self._peers[rows]) & (
            self._slack(rows, there, said) < within + 2.0 * _ROUNDING
        )
        self._rows, self._there = rows[close], there[close]

    def _slack(self, rows: Indices, there: Indices, said: Places) -> Array:
        """How far peers are from some lines, m."""
        normals = self._normals[rows]
        return normals[:, 0] * said.x[there] + normals[:, 1] * said.y[there] - self._theirs[rows]

    def leave(self, peer: int) -> None:
        """The line with this peer is looked at by itself from now on."""
        index = self._index(peer)
        if index >= 0:
            self._limits[index] = np.inf  # farther than any reach
            self._theirs[index] = -np.inf

    def rest(self, peer: int, side: HalfPlane, theirs: float) -> bool:
        """Look at the line with a peer together with the others from now on; False if one of the two may be
        near it.

        Args:
            peer: its id.
            side: where the own centre stays.
            theirs: offset along the normal of `side` beyond which the peer's centre stays, m.
        """
        if side.slack(self._looked_x, self._looked_y) < self._looked + _ROUNDING:
            return False
        if peer > self._robot and self._watched is not None:
            place = self._watched.place(peer)
            room = math.inf if place is None else side.nx * place[0] + side.ny * place[1] - theirs
            if room < self._within + 3.0 * _ROUNDING:
                return False
        index = self._index(peer)
        if index < 0:
            return False
        self._normals[index] = side.nx, side.ny
        self._limits[index], self._theirs[index] = side.limit, theirs
        return True

    def _index(self, peer: int) -> int:
        """Of the line with a peer; -1 if none can rest here."""
        index = int(self._peers.searchsorted(peer))
        return index if index < len(self._peers) and self._peers[index] == peer else -1
