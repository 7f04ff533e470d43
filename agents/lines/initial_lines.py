"""The lines of one founding life about which nothing is open, with peers that are far from them.

In a large fleet that is nearly all of them: the initial ones, which follow from starts and radii, so that
nobody is told them, or keeps an object for each; and those that were agreed on later and left behind. They
are looked at together, as often as somebody can have come near one.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Mapping
from functools import lru_cache
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from agents.lines.line import HalfPlane
from agents.peers.far import FarPicture, Places, shift
from protocol.messages import Vector
from protocol.process.newest import keeps_newest

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

_ROUNDING: Final = 1e-6  # m, more than the same line computed one by one may differ by


@final
class _Starts:
    """Where every robot begins and how large it is, in the order of ids; robots of one process share it.

    Args:
        told: starts and radii by id, m.
    """

    def __init__(self, told: tuple[Mapping[int, Vector], Mapping[int, float]]) -> None:
        starts, radii = told
        ids = sorted(starts)
        self.robots = np.array(ids, dtype=np.int64)
        self.row = {robot: row for row, robot in enumerate(ids)}
        self.x: Array = np.array([starts[robot][0] for robot in ids], dtype=np.float64)
        self.y: Array = np.array([starts[robot][1] for robot in ids], dtype=np.float64)
        self.radii: Array = np.array([radii[robot] for robot in ids], dtype=np.float64)


_starts_of = keeps_newest(_Starts)


@lru_cache(maxsize=16)  # robots of one process go back to a few summaries
def _found(starts: _Starts, said: Places) -> Indices:
    """Index in a summary of each of them, -1 if it is not there."""
    if not len(said.robots):
        return np.full(len(starts.robots), -1)
    there = np.minimum(np.searchsorted(said.robots, starts.robots), len(said.robots) - 1)
    there[said.robots[there] != starts.robots] = -1
    return there


@final
class InitialLines:
    """Each line lies in the middle of the gap between two disks at their starts (`placement.initial_line`),
    until another one is put to rest. The former are computed whenever they are looked at, and only the
    latter are kept: in each of a thousand robots, a thousand lines are more than all the rest of it.

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
        self._ahead = ahead
        self.moved_on = False
        self._looked_x = self._looked_y = 0.0
        self._looked = -1.0  # gap (m) up to which lines were looked at there
        self._starts = _starts_of((starts, radii))
        self._own = self._starts.row[robot]
        self._changed = array("q")  # rows whose line is not the initial one,
        self._place: dict[int, int] = {}  # where each of them is there,
        self._lines = array("d")  # and four numbers for each: normal and limits, as of `_each`
        self._watched: Places | None = None  # by which it was looked which peers may reach a line,
        self._within = 0.0  # m,
        self._rows: Indices = np.zeros(0, dtype=np.int64)  # and found these lines,
        self._there = self._rows  # where the summary has their peers,
        self._near_x = self._near_y = self._near_theirs = np.zeros(0)  # and their normals and limits
        self._leave(self._own)
        touching: list[int] = self._starts.robots[self._gaps()[3] < _ROUNDING].tolist()
        self.unusable = [peer for peer in touching if peer != robot]

    def _gaps(self) -> tuple[Array, Array, Array, Array]:
        """The way from the own start to each other, its length, and the gap between both disks, m."""
        starts, own = self._starts, self._own
        dx, dy = starts.x - starts.x[own], starts.y - starts.y[own]
        length = np.sqrt(dx * dx + dy * dy)
        return dx, dy, length, length - starts.radii[own] - starts.radii

    def _each(self) -> tuple[Array, Array, Array, Array]:
        """Of every line the normal, away from this robot; the limit of the own centre along that; and the one
        beyond which the peer's is, m. Lines that are looked at by themselves are farther than any reach."""
        starts, own = self._starts, self._own
        nx, ny, length, gap = self._gaps()
        np.maximum(length, 1e-12, out=length)
        nx /= length
        ny /= length
        gap *= 0.5
        limits = nx * starts.x[own] + ny * starts.y[own] + gap
        theirs = nx * starts.x + ny * starts.y - gap
        rows, lines = np.frombuffer(self._changed, dtype=np.int64), np.frombuffer(self._lines).reshape(-1, 4)
        nx[rows], ny[rows] = lines[:, 0], lines[:, 1]
        limits[rows], theirs[rows] = lines[:, 2], lines[:, 3]
        return nx, ny, limits, theirs

    def __len__(self) -> int:
        return len(self._starts.robots) - 1

    def approached(self, x: float, y: float, reach: float) -> list[int]:
        """Every peer whose line may be less than `reach` (m) from the own centre at (x, y), m, and some more.
        None is looked for as long as the centre has not moved by what the others were farther off."""
        if math.hypot(x - self._looked_x, y - self._looked_y) + reach <= self._looked:
            return []
        self._looked_x, self._looked_y, self._looked = x, y, reach + self._ahead
        self.moved_on = True
        return self.within(x, y, self._looked)

    def within(self, x: float, y: float, reach: float) -> list[int]:
        """Every peer whose line may be less than `reach` (m) from the own disk if that is at (x, y), m."""
        nx, ny, limits, _ = self._each()
        ids: list[int] = self._starts.robots[limits - nx * x - ny * y < reach + _ROUNDING].tolist()
        return ids

    def reached(self, picture: FarPicture, reach: float) -> list[int]:
        """Every peer that this robot owns the line with and that was less than `reach` (m) from it."""
        said = picture.said
        if self._watched is None or shift(self._watched, said) + reach > self._within:
            self._watch(said, reach + self._ahead)
        x, y = said.x[self._there], said.y[self._there]
        slack = self._near_x * x + self._near_y * y - self._near_theirs
        ids: list[int] = self._starts.robots[self._rows[slack < reach + _ROUNDING]].tolist()
        return ids

    def _watch(self, said: Places, within: float) -> None:
        """Note which peers of own lines were less than `within` (m) from it: the others have to go that far
        before they can reach it."""
        self._watched, self._within, self.moved_on = said, within, True
        nx, ny, _, theirs = self._each()
        there = _found(self._starts, said)
        if len(said.robots):
            slack = nx * said.x[there] + ny * said.y[there] - theirs
            close = (there >= 0) & (slack < within + 2.0 * _ROUNDING)
            close[: self._own] = False  # the lines with those are theirs
            self._note(np.flatnonzero(close), there, nx, ny, theirs)
        else:
            self._note(self._rows[:0], there, nx, ny, theirs)

    def _note(self, rows: Indices, there: Indices, nx: Array, ny: Array, theirs: Array) -> None:
        """Watch these lines, of all that there are."""
        self._rows, self._there = rows, there[rows]
        self._near_x, self._near_y, self._near_theirs = nx[rows], ny[rows], theirs[rows]

    def leave(self, peer: int) -> None:
        """The line with this peer is looked at by itself from now on."""
        row = self._starts.row.get(peer)
        if row is not None:
            self._leave(row)

    def _leave(self, row: int) -> None:
        self._put(row, 0.0, 0.0, math.inf, -math.inf)
        if row > self._own:  # else it is theirs to watch
            self._near_theirs[self._rows == row] = -math.inf

    def _put(self, row: int, *line: float) -> None:
        """Keep a line in place of an earlier one."""
        place = self._place.setdefault(row, len(self._place))
        if place == len(self._changed):
            self._changed.append(row)
            self._lines.extend(line)
        else:
            self._lines[4 * place : 4 * place + 4] = array("d", line)

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
        row = self._starts.row.get(peer)
        if row is None or row == self._own:
            return False
        if row > self._own and self._watched is not None:
            place = self._watched.place(peer)
            room = math.inf if place is None else side.nx * place[0] + side.ny * place[1] - theirs
            if room < self._within + 3.0 * _ROUNDING:
                return False
        self._put(row, side.nx, side.ny, side.limit, theirs)
        return True
