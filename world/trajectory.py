"""The trajectory's digest: two runs with equal digests moved alike to the last bit."""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Sequence

from protocol.messages import Vector


class TrajectoryDigest:
    """SHA-256 over, tick by tick and in the order of ids, the four little-endian doubles
    tick, robot id, x, y (m); begins with tick 0, before any motion."""

    def __init__(self, ids: Sequence[int]) -> None:
        self._ids = [float(robot) for robot in ids]
        self._pack = struct.Struct(f"<{4 * len(ids)}d").pack
        self._sha = hashlib.sha256()

    def add(self, tick: int, positions: Sequence[Vector]) -> None:
        """Append the truth at the start of `tick`, in the order of ids."""
        time = float(tick)
        numbers = [
            number
            for robot, (x, y) in zip(self._ids, positions, strict=True)
            for number in (time, robot, x, y)
        ]
        self._sha.update(self._pack(*numbers))

    def hexdigest(self) -> str:
        """Digest of all that was added."""
        return self._sha.hexdigest()
