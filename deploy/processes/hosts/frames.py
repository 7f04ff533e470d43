"""Messages out of a connection to a host that may stall at any byte, and may be somebody else's by now.

The framing is that of `multiprocessing.connection`: a length in four bytes, big-endian, then the message.
"""

from __future__ import annotations

import os
import select
import struct
import time
from collections.abc import Callable, Iterator
from math import inf

_HEAD = struct.Struct("!i")
_CHUNK = 1 << 16  # bytes
_AT_ONCE = 256  # messages; so that one host that never stops talking does not keep others from being heard


class Frames:
    """What comes out of `descriptor`, message by message, without ever waiting for the rest of one.

    Args:
        descriptor: is read from; stays its owner's.
        largest: bytes of a message, at most.
        patience: s that a message may take from its first byte to its last.
        clock: tells the time, s.
    """

    def __init__(
        self,
        descriptor: int,
        largest: int,
        patience: float,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._descriptor, self._largest, self._patience, self._clock = descriptor, largest, patience, clock
        self._buffer = bytearray()
        self._began = inf  # s, when a message began that is not complete

    def read(self, timeout: float) -> Iterator[bytes]:
        """What has arrived, after at most `timeout` s of waiting for it.

        Raises:
            EOFError: the connection has ended.
            ValueError: what comes is no message, or does not come to an end.
        """
        for _ in range(_AT_ONCE):
            message = self._complete()
            if message is None:
                if not select.select([self._descriptor], [], [], timeout)[0]:
                    break
                arrived = os.read(self._descriptor, _CHUNK)
                if not arrived:
                    raise EOFError
                self._buffer += arrived
            else:
                yield message
            timeout = 0.0
        self._check_patience()

    def _complete(self) -> bytes | None:
        """The first message in the buffer, once it is there as a whole."""
        if len(self._buffer) < _HEAD.size:
            return None
        (length,) = _HEAD.unpack_from(self._buffer)
        if not 0 <= length <= self._largest:
            raise ValueError(f"a message of {length} bytes")
        end = _HEAD.size + length
        if len(self._buffer) < end:
            return None
        message = bytes(self._buffer[_HEAD.size : end])
        del self._buffer[:end]
        self._began = inf
        return message

    def _check_patience(self) -> None:
        if not self._buffer:
            return
        now = self._clock()
        self._began = min(self._began, now)
        if now > self._began + self._patience:
            raise ValueError(f"it stalled in the middle of a message for {self._patience:g} s")
