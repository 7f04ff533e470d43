"""Random draws by counter: the same key gives the same numbers, independent of earlier draws.

Every draw is keyed by (seed, purpose, robot, tick), with one column per peer where pairs matter (a separate
key for each robot that joins later), so neither the order of messages nor the transport can change a run.
"""

from __future__ import annotations

from enum import IntEnum
from operator import index

import numpy as np
from numpy.random import Generator, Philox

from protocol.errors import UsageError

LARGEST_SEED = 2**63 - 1


class Purpose(IntEnum):
    """Purpose of a draw; each has its own numbers."""

    SENSING = 1
    LINK = 2
    ACTUATION = 3
    SCENARIO = 4
    STUDY = 5
    CONTROL = 6
    ODOMETRY = 7
    RADIO = 8


_MASK = (1 << 64) - 1


def checked_seed(seed: object) -> int:
    """A seed as a program gave it, such as an integer of numpy; raises UsageError if it is none."""
    try:
        number = -1 if isinstance(seed, bool) else index(seed)  # type: ignore[arg-type]  # `index` rejects other types
    except TypeError:
        number = -1
    if not 0 <= number <= LARGEST_SEED:
        raise UsageError(f"seed {seed!r}: give a whole number from 0 to {LARGEST_SEED}")
    return number


def generator(seed: int, purpose: Purpose, robot: int = 0, tick: int = 0, peer: int = 0) -> Generator:
    """A numpy generator for a key; `seed` is any non-negative integer, ids and ticks below 2**32."""
    key = np.array([seed & _MASK, (int(purpose) << 56) ^ (seed >> 64)], dtype=np.uint64)
    counter = np.array([0, peer, robot, tick], dtype=np.uint64)
    return Generator(Philox(key=key, counter=counter))


_BLOCK = 64  # ticks drawn at once: making a generator costs as much as some hundred numbers


class Uniforms:
    """Uniform numbers in [0, 1) of one robot, `columns` of them a tick; the newest `kept` blocks of ticks are
    not drawn again."""

    def __init__(self, seed: int, purpose: Purpose, robot: int, columns: int, kept: int = 1) -> None:
        self._key = (seed, purpose, robot)
        self._columns, self._kept = columns, kept
        self._blocks: dict[int, list[list[float]]] = {}

    def at(self, tick: int) -> list[float]:
        """The numbers of one tick."""
        number, row = divmod(tick, _BLOCK)
        block = self._blocks.get(number)
        if block is None:
            source = generator(*self._key, number)
            block = self._blocks[number] = source.random((_BLOCK, self._columns)).tolist()
            if len(self._blocks) > self._kept:
                del self._blocks[next(iter(self._blocks))]
        return block[row]
