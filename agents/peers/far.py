"""Where everybody was, by the world's last summary: what a robot knows of those whom it does not hear."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import final

import numpy as np
from numpy.typing import NDArray

from agents.navigation.far_field import FarField, far_field
from protocol.errors import MessageError
from protocol.messages import Summary
from protocol.wire.codec import LARGEST

Array = NDArray[np.float64]
Vector = tuple[float, float]


@final
class FarPicture:
    """One summary.

    Args:
        summary: that has arrived.
        radii: of all robots, m.
        before: an earlier picture, for what has not changed since.

    Attributes:
        tick: that it is of.
        robots: who is in it, ascending.
        places: of them, m; shape (n, 2).

    Raises:
        MessageError: it is not made as a summary is.
    """

    def __init__(
        self, summary: Summary, radii: Mapping[int, float], before: FarPicture | None = None
    ) -> None:
        self.tick = summary.tick
        count = len(summary.gammas) // 4
        sizes_fit = len(summary.gammas) == len(summary.slices) == 4 * count
        if not sizes_fit or len(summary.positions) != 8 * count:
            raise MessageError(
                "shape", "summary: as many positions as squared distances and slices are needed"
            )
        self.places: Array = np.frombuffer(summary.positions, dtype="<f4").astype(np.float64).reshape(-1, 2)
        self._gammas: Array = np.frombuffer(summary.gammas, dtype="<f4").astype(np.float64)
        self._slices: Array = np.frombuffer(summary.slices, dtype="<f4").astype(np.float64)
        sound = (self._gammas >= 0.0).all() and (self._slices >= 0.0).all()
        if not (sound and (np.abs(self.places) <= LARGEST).all()):
            raise MessageError("not-finite", "summary: holds a number that is infinite, absurd or none")
        self._runs = summary.robots
        self.robots: NDArray[np.int64]
        if before is not None and before._runs == summary.robots and len(before.robots) == count:
            self.robots, index, sizes = before.robots, before._index, before._radii
        else:
            self.robots = _ids(summary.robots, count)
            known: list[int] = self.robots.tolist()
            index = {robot: place for place, robot in enumerate(known)}
            sizes = np.array([radii.get(robot, 0.0) for robot in known], dtype=np.float64)
        self._index: dict[int, int] = index
        self._radii: Array = sizes

    def place(self, robot: int) -> Vector | None:
        """Where a robot was, m; None if nobody knows."""
        index = self._index.get(robot)
        return None if index is None else (self.places.item(2 * index), self.places.item(2 * index + 1))

    def field(self, position: Vector, radius: float, known: Collection[int]) -> FarField:
        """What all of them but the `known` add to a robot's slice near its own position.

        Args:
            position: own, m.
            radius: own, m.
            known: robots that are known better, own id included, each once.
        """
        index = [self._index[robot] for robot in known if robot in self._index]
        terms = (self.places, radius + self._radii, self._gammas, self._slices)
        return far_field(self.tick, position, *terms, index)


def _ids(runs: bytes, count: int) -> NDArray[np.int64]:
    """The ids that `runs` stand for (`protocol.messages.Summary`); there have to be `count`."""
    if len(runs) % 8:
        raise MessageError("shape", "summary: a run of ids is two numbers")
    pairs = np.frombuffer(runs, dtype="<u4").astype(np.int64).reshape(-1, 2)
    first, many = pairs[:, 0], pairs[:, 1]
    if int(many.sum()) != count:
        raise MessageError("shape", "summary: as many ids as positions are needed")
    ids: NDArray[np.int64] = np.repeat(first - np.cumsum(many) + many, many) + np.arange(count)
    if (np.diff(ids) <= 0).any():
        raise MessageError("shape", "summary: ids have to ascend")
    return ids
