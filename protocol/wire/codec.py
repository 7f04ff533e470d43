"""Encoding and checked decoding of messages.

Whatever arrives is untrusted. A payload is accepted only if its size, version, type, shape and
numbers are right and it speaks under its own key; else MessageError names one of `REASONS`.
"""

from __future__ import annotations

from typing import Final

import msgspec

from protocol.messages import AnyMessage, Command, Message, Tick
from protocol.wire.reader import reader

REASONS = ("key", "oversize", "version", "type", "shape", "identity", "epoch")

_pack = msgspec.msgpack.encode


def _with_defaults(message: type[Message]) -> tuple[tuple[str, object], ...]:
    """Fields that may be left out, and what they are then, from the last one on."""
    defaults = message.__struct_defaults__
    fields = message.__struct_fields__[-len(defaults) :]
    return tuple(zip(reversed(fields), reversed(defaults), strict=True))


_OF_TICK: Final = _with_defaults(Tick)
_OF_COMMAND: Final = _with_defaults(Command)


def encode(message: Message) -> bytes:
    """A message as it travels. Ticks and Commands cross links between hosts in every tick: they end with the
    last field that is not as it is by default."""
    if isinstance(message, Tick):
        return _shortened(message, _OF_TICK)
    if isinstance(message, Command):
        return _shortened(message, _OF_COMMAND)
    return _pack(message)


def _shortened(message: Message, fields: tuple[tuple[str, object], ...]) -> bytes:
    """Without `fields` at the end that are as by default: each of those is one byte of a short array."""
    payload, spare = _pack(message), 0
    for name, default in fields:
        if getattr(message, name) != default:
            break
        spare += 1
    return bytes((payload[0] - spare,)) + payload[1 : len(payload) - spare] if spare else payload


def decode(key: str, payload: bytes) -> AnyMessage:
    """Decode what arrived under `key`.

    Raises:
        MessageError: with `reason` in `REASONS`.
    """
    return reader(key).read(payload)
