"""The trajectory's digest: two runs with equal digests moved alike to the last bit."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from protocol.messages import Vector

Configurations = Sequence[Sequence[Vector]] | NDArray[np.float64]  # shape (n, p, 2)


class TrajectoryDigest:
    """SHA-256 over, tick by tick and in the order of ids, the four little-endian doubles
    tick, robot id, x, y (m)."""

    def __init__(self, ids: Sequence[int]) -> None:
        self._ids = np.array(ids, dtype="<f8")
        self._sha = hashlib.sha256()

    def set_fleet(self, ids: Sequence[int]) -> None:
        """Other robots from now on."""
        self._ids = np.array(ids, dtype="<f8")

    def add(self, ticks: Sequence[int], configurations: Configurations) -> None:
        """Append the truth at the start of each of `ticks`, which do not decrease, in the order of ids."""
        rows = np.empty((len(ticks), len(self._ids), 4), dtype="<f8")
        rows[..., 0] = np.asarray(ticks)[:, None]
        rows[..., 1] = self._ids
        rows[..., 2:] = configurations
        self._sha.update(rows.tobytes())

    def hexdigest(self) -> str:
        """Digest of all that was added."""
        return self._sha.hexdigest()
