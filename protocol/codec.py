"""Encoding and checked decoding of messages.

Every payload is untrusted. It is accepted only if its size, version, type, shape and numbers are valid and
its sender's id is that of its key; otherwise MessageError has one of `REASONS`. States, which a robot reads
once per peer and tick, are read by a `Cursor` where possible.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any, Final, TypeVar, final

import msgspec
from librt.strings import read_f64_be, read_i16_be, read_i32_be
from mypy_extensions import i64, mypyc_attr

from protocol.errors import KeyGrammarError, MessageError
from protocol.keys import STREAMS, parse
from protocol.messages import VERSION, AnyMessage, Message

_TAG = re.compile(r"([a-z]+)/([0-9]+)")
_DECODE: dict[str, Any] = {
    name: msgspec.msgpack.Decoder(stream.message).decode for name, stream in STREAMS.items()
}
# Errors of decoding.
DAMAGED = (msgspec.DecodeError, UnicodeDecodeError, RecursionError)
SHOWN = 300  # characters of the reason that are logged, escaped: a stranger may have written them
REASONS = ("key", "oversize", "version", "type", "shape", "identity", "epoch")
Value = TypeVar("Value")
Made = TypeVar("Made")


def encode(message: Message) -> bytes:
    """A message as sent."""
    return msgspec.msgpack.encode(message)


def decode(key: str, payload: bytes) -> AnyMessage:
    """Decode a payload of `key`; raises MessageError with `reason` in `REASONS`."""
    try:
        address = parse(key)
    except KeyGrammarError as error:
        raise MessageError("key", str(error)) from None
    return read(address.stream, address.robot, payload)


def read(stream: str, robot: int | None, payload: bytes) -> AnyMessage:
    """Decode a payload of a stream of a `robot`, or of the world (None); raises MessageError."""
    declared = STREAMS.get(stream)
    if declared is None:
        raise MessageError("key", f"nothing is published under a key that ends in {stream!r}")
    if len(payload) > declared.limit:
        raise MessageError("oversize", f"{stream}: {len(payload)} bytes, at most {declared.limit} are read")
    try:
        message: AnyMessage = _DECODE[stream](payload)
    except DAMAGED as error:
        raise _refusal(stream, payload, error) from None
    if getattr(message, "robot", robot) != robot:
        raise MessageError("identity", f"{stream}: names another robot than its key, which says {robot}")
    return message


def _refusal(stream: str, payload: bytes, error: Exception) -> MessageError:
    """Error of a payload that did not decode: of another version, another type, or of the wrong shape."""
    try:
        content = msgspec.msgpack.decode(payload)
    except DAMAGED:
        return MessageError("shape", f"{stream}: not msgpack ({error})")
    tag = content[0] if isinstance(content, list) and content else None
    found = _TAG.fullmatch(tag) if isinstance(tag, str) else None
    if found is None:
        return MessageError(
            "type", f"{stream}: does not begin with a type and version such as '{stream}/{VERSION}'"
        )
    if found[2] != str(VERSION):
        return MessageError("version", f"{stream}: protocol version {found[2]}, this is version {VERSION}")
    if found[1] != stream:
        return MessageError("type", f"{stream}: holds a {found[1]}")
    return MessageError("shape", f"{stream}: {error}")


def keeps_newest(make: Callable[[Value], Made]) -> Callable[[Value], Made]:
    """`make`, with its newest result kept for the next call with equal arguments. Unlike `lru_cache` it
    hashes nothing, which for a thousand robots takes as long as `make`.
    """
    kept: list[tuple[Value, Made]] = []

    def found(value: Value) -> Made:
        newest = kept[0] if kept else None  # read once: another thread may replace it
        if newest is None or value is not newest[0]:
            newest = value, make(value) if newest is None or value != newest[0] else newest[1]
            kept[:] = [newest]  # the same object again is found without a comparison
        return newest[1]

    return found


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
    """A position in a msgpack payload in the usual encoding of libraries: short integers, 64-bit floats.

    It advances with every value, and creates objects only for values that the caller reads. Other valid
    encodings, and truncated payloads, raise IndexError, and are left to `decode`.
    """

    __slots__ = ("_payload", "at")

    def __init__(self, payload: bytes, at: i64) -> None:
        self._payload = payload
        self.at: i64 = at  # index of the next byte

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
        """Whether the next value is nil, which is skipped; any other remains."""
        if self._payload[self.at] != _NONE:
            return False
        self.at += 1
        return True

    def array(self) -> i64:
        """Number of elements of an array that follows."""
        head: i64 = self._payload[self.at]
        if _ARRAY <= head < _ARRAY + 16:
            self.at += 1
            return head - _ARRAY
        if head == _ARRAY16:
            self.at += 3
            return i64(read_i16_be(self._payload, self.at - 2)) & 0xFFFF
        raise IndexError("no array")

    def enter(self, elements: i64) -> None:
        """Enter an array with exactly this number of elements."""
        if self.array() != elements:
            raise IndexError("another number of elements")
