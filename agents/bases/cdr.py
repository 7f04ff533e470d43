"""CDR, the encoding of ROS 2 messages: numbers stand at multiples of their size, texts end in a zero byte.

The first four bytes say which way round numbers are; places are counted after them (OMG CDR 1, encapsulation
`CDR_BE` and `CDR_LE` of DDS-RTPS).
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from typing import Any, Final

from protocol.errors import MessageError

_LITTLE: Final = b"\0\1\0\0"
_START: Final = 4


class CdrReader:
    """Takes one value after another from a payload.

    Raises:
        MessageError: the payload is of another encoding, or too short for what is taken from it.
    """

    def __init__(self, payload: bytes) -> None:
        if len(payload) < _START or payload[0] != 0 or payload[1] not in (0, 1):
            raise MessageError("shape", "no CDR: the first two bytes are neither 0 0 nor 0 1")
        self._payload, self._place = payload, _START
        self._order = "<" if payload[1] else ">"

    def numbers(self, form: str, size: int, count: int = 1) -> tuple[int | float, ...]:
        """`count` numbers of `size` bytes each, of a kind that `struct` calls `form`."""
        return self._take(f"{self._order}{count}{form}", size, size * count)

    def doubles(self, count: int) -> tuple[float, ...]:
        """So many doubles."""
        return self._take(f"{self._order}{count}d", 8, 8 * count)

    def text(self) -> str:
        """A text."""
        (length,) = self._take(f"{self._order}I", 4, 4)
        (raw,) = self._take(f"{length}s", 1, length)
        try:
            return str(raw.rstrip(b"\0"), "utf-8")
        except UnicodeDecodeError as error:
            raise MessageError("shape", f"a text that is no UTF-8: {error}") from None

    def _take(self, form: str, align: int, length: int) -> tuple[Any, ...]:
        begin = self._place + -(self._place - _START) % align
        self._place = begin + length
        if self._place > len(self._payload):
            raise MessageError("shape", f"{len(self._payload)} bytes, and at least {self._place} are needed")
        return struct.unpack_from(form, self._payload, begin)


class CdrWriter:
    """Puts one value after another into a payload, the low bytes of numbers first."""

    def __init__(self) -> None:
        self._payload = bytearray(_LITTLE)

    @property
    def payload(self) -> bytes:
        """Everything so far."""
        return bytes(self._payload)

    def numbers(self, form: str, size: int, values: Iterable[float]) -> None:
        """Numbers of `size` bytes each, of a kind that `struct` calls `form`."""
        self._align(size)
        for value in values:
            self._payload += struct.pack(f"<{form}", value)

    def doubles(self, values: Iterable[float]) -> None:
        """Doubles."""
        self.numbers("d", 8, values)

    def text(self, text: str) -> None:
        """A text."""
        raw = text.encode() + b"\0"
        self.numbers("I", 4, (len(raw),))
        self._payload += raw

    def _align(self, size: int) -> None:
        self._payload += bytes(-(len(self._payload) - _START) % size)
