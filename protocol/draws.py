"""Random draws by counter: the same key gives the same numbers, whatever was drawn before.

Every draw is keyed by (seed, purpose, robot, tick), with one column per peer where pairs matter (a key of its
own for each who joins later), so neither the order in which messages arrive nor the transport can change
a run.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from numpy.random import Generator, Philox


class Purpose(IntEnum):
    """What a draw is for; each purpose has numbers of its own."""

    SENSING = 1
    LINK = 2
    ACTUATION = 3
    SCENARIO = 4
    STUDY = 5
    CONTROL = 6
    ODOMETRY = 7


_MASK = (1 << 64) - 1


def generator(seed: int, purpose: Purpose, robot: int = 0, tick: int = 0, peer: int = 0) -> Generator:
    """A numpy generator for one key; `seed` is any non-negative integer, ids and ticks below 2**32."""
    key = np.array([seed & _MASK, (int(purpose) << 56) ^ (seed >> 64)], dtype=np.uint64)
    counter = np.array([0, peer, robot, tick], dtype=np.uint64)
    return Generator(Philox(key=key, counter=counter))
