"""Where everybody was, by the world's last summary: what a robot knows of those whom it does not hear.

Robots of one process are sent the same bytes, which are read once for all of them. What is shared follows
from the bytes alone and is read-only; what depends on the robot, radii and its own place, is in its picture.
A process with one robot reads each summary once, too.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from functools import lru_cache
from typing import final

import numpy as np
from mypy_extensions import mypyc_attr
from numpy.typing import NDArray

from agents.navigation.far_field import FarField, far_field
from protocol.errors import MessageError
from protocol.messages import AnyMessage, Summary
from protocol.wire.codec import LARGEST, decode

Array = NDArray[np.float64]
Vector = tuple[float, float]


@lru_cache(maxsize=1)
def read_summary(key: str, payload: bytes) -> AnyMessage:
    """`decode` a summary: once, if one payload comes to several robots of a process.

    Raises:
        MessageError: as `decode` does.
    """
    return decode(key, payload)


@final
@mypyc_attr(acyclic=True)
class Places:
    """What one summary says, for whoever reads it; nobody changes it.

    Args:
        summary: that has arrived.

    Attributes:
        tick: that it is of.
        runs: who is in it, as in the summary.
        robots: the same, ascending.
        index: of each in the arrays.
        places: m; shape (n, 2).
        gammas, slices: as in the summary, m^2 and m.

    Raises:
        MessageError: it is not made as a summary is.
    """

    __slots__ = ("gammas", "index", "places", "robots", "runs", "slices", "tick")

    def __init__(self, summary: Summary) -> None:
        self.tick, self.runs = summary.tick, summary.robots
        count = len(summary.gammas) // 4
        sizes_fit = len(summary.gammas) == len(summary.slices) == 4 * count
        if not sizes_fit or len(summary.positions) != 8 * count:
            raise MessageError(
                "shape", "summary: as many positions as squared distances and slices are needed"
            )
        self.places: Array = _numbers(summary.positions).reshape(-1, 2)
        self.gammas: Array = _numbers(summary.gammas)
        self.slices: Array = _numbers(summary.slices)
        sound = (self.gammas >= 0.0).all() and (self.slices >= 0.0).all()
        if not (sound and (np.abs(self.places) <= LARGEST).all()):
            raise MessageError("not-finite", "summary: holds a number that is infinite, absurd or none")
        robots, index = _ids(summary.robots, count)
        self.robots: NDArray[np.int64] = robots
        self.index: Mapping[int, int] = index


places_of = lru_cache(maxsize=1)(Places)


@final
class FarPicture:
    """One summary, as one robot sees it.

    Args:
        said: by the summary.
        radii: of all robots, m.
        before: an earlier picture, for what has not changed since.

    Attributes:
        tick: that it is of.
        robots: who is in it, ascending.
        places: of them, m; shape (n, 2).
    """

    def __init__(self, said: Places, radii: Mapping[int, float], before: FarPicture | None = None) -> None:
        self.tick = said.tick
        self.robots: NDArray[np.int64] = said.robots
        self.places: Array = said.places
        self._said = said
        if before is not None and before._said.runs == said.runs:
            sizes = before._radii
        else:
            sizes = np.array([radii.get(robot, 0.0) for robot in said.index], dtype=np.float64)
        self._radii: Array = sizes

    def place(self, robot: int) -> Vector | None:
        """Where a robot was, m; None if nobody knows."""
        index = self._said.index.get(robot)
        return None if index is None else (self.places.item(2 * index), self.places.item(2 * index + 1))

    def field(self, position: Vector, radius: float, known: Collection[int]) -> FarField:
        """What all of them but the `known` add to a robot's slice near its own position.

        Args:
            position: own, m.
            radius: own, m.
            known: robots that are known better, own id included, each once.
        """
        index = [self._said.index[robot] for robot in known if robot in self._said.index]
        terms = (self.places, radius + self._radii, self._said.gammas, self._said.slices)
        return far_field(self.tick, position, *terms, index)


def _numbers(payload: bytes) -> Array:
    """Of single precision, to be read only."""
    numbers: Array = np.frombuffer(payload, dtype="<f4").astype(np.float64)
    numbers.setflags(write=False)
    return numbers


@lru_cache(maxsize=1)  # they seldom change
def _ids(runs: bytes, count: int) -> tuple[NDArray[np.int64], Mapping[int, int]]:
    """The ids that `runs` stand for (`protocol.messages.Summary`), of which there have to be `count`, and
    where each is among them."""
    if len(runs) % 8:
        raise MessageError("shape", "summary: a run of ids is two numbers")
    pairs = np.frombuffer(runs, dtype="<u4").astype(np.int64).reshape(-1, 2)
    first, many = pairs[:, 0], pairs[:, 1]
    if int(many.sum()) != count:
        raise MessageError("shape", "summary: as many ids as positions are needed")
    ids: NDArray[np.int64] = np.repeat(first - np.cumsum(many) + many, many) + np.arange(count)
    if (np.diff(ids) <= 0).any():
        raise MessageError("shape", "summary: ids have to ascend")
    ids.setflags(write=False)
    known: list[int] = ids.tolist()
    return ids, {robot: place for place, robot in enumerate(known)}
