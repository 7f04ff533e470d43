"""The trajectory's digest: two runs with equal digests moved alike to the last bit."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from protocol.messages import Vector

LINK = 1 << 13  # ticks after which a digest is reset, with the one so far

Configurations = Sequence[Sequence[Vector]] | NDArray[np.float64]  # shape (n, p, 2)


class TrajectoryDigest:
    """SHA-256 over, tick by tick and in the order of ids, the four little-endian doubles
    tick, robot id, x, y (m); begins with tick 0, before any motion.

    Before the first tick after every `LINK`th it is reset, with the 32 bytes of the digest so far: those
    are all that has to be kept of a long run then, so that is when a digest can be pickled.
    """

    def __init__(self, ids: Sequence[int]) -> None:
        self._ids = np.array(ids, dtype="<f8")
        self._sha: Any = hashlib.sha256()  # None if nothing came after what was pickled
        self._before = b""  # digest of what was pickled
        self._newest = 0
        self._end = LINK  # last tick of this link

    def set_fleet(self, ids: Sequence[int]) -> None:
        """Other robots from now on."""
        self._ids = np.array(ids, dtype="<f8")

    def add(self, ticks: Sequence[int] | NDArray[np.int64], configurations: Configurations) -> None:
        """Append the truth at the start of each of `ticks`, which do not decrease, in the order of ids."""
        rows = np.empty((len(ticks), len(self._ids), 4), dtype="<f8")
        rows[..., 0] = np.asarray(ticks)[:, None]
        rows[..., 1] = self._ids
        rows[..., 2:] = configurations
        while len(rows) and ticks[-1] > self._end:
            first = int(np.searchsorted(ticks, self._end, side="right"))
            self._append(rows[:first])
            self._sha = hashlib.sha256(self._digest())
            self._end += LINK
            rows, ticks = rows[first:], ticks[first:]
        self._append(rows)
        self._newest = int(ticks[-1]) if len(ticks) else self._newest

    def hexdigest(self) -> str:
        """Digest of all that was added."""
        return self._digest().hex()

    def _digest(self) -> bytes:
        return self._before if self._sha is None else bytes(self._sha.digest())

    def _append(self, rows: NDArray[np.float64]) -> None:
        if len(rows):
            self._sha.update(rows.tobytes())

    def __getstate__(self) -> dict[str, Any]:
        if self._newest != self._end:
            raise ValueError(f"a digest can be pickled at tick {self._end}, not at {self._newest}")
        return {**vars(self), "_sha": None, "_before": self._digest()}
