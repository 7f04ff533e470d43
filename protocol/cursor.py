"""Goes through a msgpack message of the form in which libraries write it: short integers, 64-bit floats.

For payloads that a robot reads once per peer and tick: it creates objects only for values that the caller
reads. Any other encoding that msgpack allows, or a truncated payload, raises IndexError, and is left to
`protocol.codec`.
"""

from __future__ import annotations

from typing import Final, final

from librt.strings import read_f64_be, read_i16_be, read_i32_be
from mypy_extensions import i64, mypyc_attr

_NONE: Final = 0xC0
_FLOAT64: Final = 0xCB
_UINT8: Final = 0xCC
_UINT16: Final = 0xCD
_UINT32: Final = 0xCE
_ARRAY: Final = 0x90  # of up to 15 elements
_ARRAY16: Final = 0xDC


@final
@mypyc_attr(acyclic=True)
class Cursor:
    """A place in `payload` that moves on with everything read.

    All methods raise IndexError if there is something else than they read.

    Attributes:
        at: index of the next byte.
    """

    __slots__ = ("_payload", "at")

    def __init__(self, payload: bytes, at: i64) -> None:
        self._payload = payload
        self.at: i64 = at

    def count(self) -> i64:
        """An integer from 0 to 2^32 - 1."""
        payload, at = self._payload, self.at
        head: i64 = payload[at]
        if head < 0x80:
            self.at = at + 1
            return head
        if head == _UINT8:
            self.at = at + 2
            return payload[at + 1]
        if head == _UINT16:
            self.at = at + 3
            return i64(read_i16_be(payload, at + 1)) & 0xFFFF
        if head == _UINT32:
            self.at = at + 5
            return i64(read_i32_be(payload, at + 1)) & 0xFFFFFFFF
        raise IndexError("no short integer")

    def number(self) -> float:
        """A floating-point number; 0 may be an integer."""
        at = self.at
        head: i64 = self._payload[at]
        if head == 0:
            self.at = at + 1
            return 0.0
        if head != _FLOAT64:
            raise IndexError("no 64-bit float")
        self.at = at + 9
        return read_f64_be(self._payload, at + 1)

    def none(self) -> bool:
        """Whether there is nothing; what there is remains to be read."""
        if self._payload[self.at] != _NONE:
            return False
        self.at += 1
        return True

    def array(self) -> i64:
        """How many elements follow as an array."""
        head: i64 = self._payload[self.at]
        if _ARRAY <= head < _ARRAY + 16:
            self.at += 1
            return head - _ARRAY
        if head == _ARRAY16:
            self.at += 3
            return i64(read_i16_be(self._payload, self.at - 2)) & 0xFFFF
        raise IndexError("no array")

    def enter(self, elements: i64) -> None:
        """Exactly so many elements follow as an array."""
        if self.array() != elements:
            raise IndexError("another number of elements")
