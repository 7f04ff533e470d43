"""Space set aside on a disk, so that a file there can still be closed properly when the disk is full."""

from __future__ import annotations

import os
from pathlib import Path
from tempfile import TemporaryFile

_STEP = 1 << 18  # bytes


class Spare:
    """A nameless file beside another: it goes when this process does, however that ends.

    Raises:
        OSError: (`hold`) there is no more space.
    """

    def __init__(self, beside: Path) -> None:
        self._file = TemporaryFile(dir=beside.parent, buffering=0)  # noqa: SIM115  closed by `release`
        self._size = 0

    def hold(self, size: int) -> None:
        """Have at least `size` bytes set aside."""
        while self._size < size:
            self._size += self._file.write(os.urandom(_STEP)) or 0  # zeros might take no space

    def release(self) -> None:
        """Give it all back; may be called twice."""
        self._file.close()
