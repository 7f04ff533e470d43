"""Encoding and checked decoding of messages.

Whatever arrives is untrusted. A payload is accepted only if its size, version, type, shape and
numbers are right and it speaks under its own key; else MessageError names one of `REASONS`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from math import isfinite
from typing import Any

import msgspec

from protocol.errors import KeyGrammarError, MessageError
from protocol.keys import parse
from protocol.messages import (
    VERSION,
    AnyMessage,
    Clock,
    Command,
    Health,
    Measurement,
    State,
    Truth,
)
from protocol.streams import STREAMS

REASONS = ("key", "oversize", "version", "type", "shape", "not-finite", "identity")

_READERS: dict[str, tuple[msgspec.msgpack.Decoder[Any], int]] = {
    name: (msgspec.msgpack.Decoder(stream.message), stream.limit) for name, stream in STREAMS.items()
}
_TAG = re.compile(r"([a-z]+)/([0-9]+)")

encode = msgspec.msgpack.encode


def decode(key: str, payload: bytes) -> AnyMessage:
    """Decode what arrived under `key`.

    Raises:
        MessageError: with `reason` in `REASONS`.
    """
    message = decode_unchecked(key, payload)
    check_finite(parse(key).stream, message)
    return message


def decode_unchecked(key: str, payload: bytes) -> AnyMessage:
    """See `decode`; but numbers may be infinite, or none. For who sees that later anyway."""
    try:
        address = parse(key)
    except KeyGrammarError as error:
        raise MessageError("key", str(error)) from None
    return decode_numbers(address.stream, address.robot, payload)


def decode_stream(stream: str, robot: int | None, payload: bytes) -> AnyMessage:
    """Decode a payload of `stream`; `robot` is the id in its key (None for the world's streams).

    Raises:
        MessageError: with `reason` in `REASONS`.
    """
    message = decode_numbers(stream, robot, payload)
    check_finite(stream, message)
    return message


def decode_numbers(stream: str, robot: int | None, payload: bytes) -> AnyMessage:
    """See `decode_stream`; but numbers may be infinite, or none. For who sees that later anyway."""
    if stream not in _READERS:
        raise MessageError("key", f"nothing is published under a key that ends in {stream!r}")
    decoder, limit = _READERS[stream]
    if len(payload) > limit:
        raise MessageError("oversize", f"{stream}: {len(payload)} bytes, at most {limit} are read")
    try:
        message: AnyMessage = decoder.decode(payload)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise _refusal(stream, payload, error) from None
    if getattr(message, "robot", robot) != robot:
        raise MessageError("identity", f"{stream}: names another robot than its key, which says {robot}")
    return message


def check_finite(stream: str, message: AnyMessage) -> None:
    """Refuse a message of `stream` that holds a number which is infinite, or none.

    Raises:
        MessageError: not-finite.
    """
    if not _is_finite(message):
        raise MessageError("not-finite", f"{stream}: holds a number that is infinite or not a number")


def _refusal(stream: str, payload: bytes, error: Exception) -> MessageError:
    """Say why a payload did not decode: of another version, another type, or of the wrong shape."""
    try:
        content = msgspec.msgpack.decode(payload)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
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


def _is_finite(message: AnyMessage) -> bool:
    """Whether all numbers of a message are finite. A sum is finite only if all its terms are: for those
    of every tick that costs a third of looking at each number, which is left to sums that overflow."""
    if isinstance(message, State):
        total = _state_sum(message)
    elif isinstance(message, Command):
        total = sum(message.velocity)
    elif isinstance(message, Measurement) and not message.down:
        total = sum(message.displacement, sum(message.position or ()))
    else:
        return all(map(isfinite, _numbers(message)))
    return isfinite(total) or all(map(isfinite, _numbers(message)))


def _state_sum(state: State) -> float:
    """Sum of all floating-point numbers of a State."""
    vx, vy = state.desired
    total = state.bound + state.gamma + state.slice + vx + vy
    if state.position is not None:
        x, y = state.position
        total += x + y
    for line in state.proposals:
        total += line.nx + line.ny + line.offset
    return total


def _numbers(message: AnyMessage) -> Iterator[float]:
    """All floating-point numbers of a message."""
    if isinstance(message, State):
        return _state_numbers(message)
    if isinstance(message, Command):
        return iter(message.velocity)
    if isinstance(message, Measurement):
        return _measurement_numbers(message)
    return _watched_numbers(message)


def _state_numbers(state: State) -> Iterator[float]:
    yield from state.desired
    yield state.bound
    yield state.gamma
    yield state.slice
    if state.position is not None:
        yield from state.position
    for line in state.proposals:
        yield line.nx
        yield line.ny
        yield line.offset


def _measurement_numbers(measurement: Measurement) -> Iterator[float]:
    yield from measurement.displacement
    if measurement.position is not None:
        yield from measurement.position
    for down in measurement.down:
        yield from down.position


def _watched_numbers(message: AnyMessage) -> Iterator[float]:
    if isinstance(message, Clock):
        yield from (message.time, message.clearance, message.phi)
        for down in message.down:
            yield from down.position
    elif isinstance(message, Truth):
        yield message.clearance
        yield message.phi
        for position in message.positions:
            yield from position
    elif isinstance(message, Health):
        yield message.bound
        for _, nx, ny, limit in message.lines:
            yield from (nx, ny, limit)
