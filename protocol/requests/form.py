"""The form of requests: maps in msgpack or, for people and stock tools, in JSON; replies are in the same."""

from __future__ import annotations

from typing import TypeVar

import msgspec

from protocol.codec import DAMAGED
from protocol.errors import MessageError

T = TypeVar("T")


def read_request(payload: bytes, kind: type[T], what: str, limit: int) -> T:
    """A request of `kind`.

    Args:
        what: it is, in errors.
        limit: bytes that are read at most.

    Raises:
        MessageError: oversize, or shape.
    """
    if len(payload) > limit:
        raise MessageError("oversize", f"{what} request: {len(payload)} bytes, at most {limit} are read")
    try:
        return msgspec.msgpack.decode(_packed(payload) if is_json(payload) else payload, type=kind)
    except OverflowError:
        raise MessageError("shape", f"{what} request: has an integer of more than 64 bits") from None
    except DAMAGED as error:
        raise MessageError("shape", f"{what} request: {error}") from None


def _packed(text: bytes) -> bytes:
    """JSON text in msgpack: nothing can be said in the one form that could not be passed on in the other.

    Raises:
        OverflowError: it has an integer of more than 64 bits.
    """
    return msgspec.msgpack.encode(msgspec.json.decode(text))


def encode_reply(reply: msgspec.Struct, request: bytes) -> bytes:
    """Payload of a reply, in the form of the request."""
    return msgspec.json.encode(reply) if is_json(request) else msgspec.msgpack.encode(reply)


def read_reply(payload: bytes, kind: type[T], what: str) -> T:
    """A reply of `kind` in msgpack; raises MessageError."""
    try:
        return msgspec.msgpack.decode(payload, type=kind)
    except DAMAGED as error:
        raise MessageError("shape", f"reply to a {what} request: {error}") from None


def is_json(payload: bytes) -> bool:
    """Whether a request is JSON text; no map in msgpack begins like that."""
    return payload[:1] in (b"{", b" ", b"\n", b"\t")
