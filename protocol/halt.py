"""The emergency stop: a request under `world/halt`, which the world answers.

`{"halt": true}` has everybody stand from the next tick on, `{"halt": false}` releases them; an empty request
asks how things stand. Maps in msgpack, or JSON text; the reply comes in the form of the request. Robots go on
talking about their lines meanwhile, and a robot that is not released does not move, whoever commands it.
"""

from __future__ import annotations

import msgspec

from protocol.errors import MessageError
from protocol.goals import is_json
from protocol.messages import Count

LIMIT = 1024  # bytes of a request


class Halt(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What is asked."""

    halt: bool


class Halted(msgspec.Struct, frozen=True):
    """How things stand."""

    halted: bool
    tick: Count  # the first in which that is so, or the present one


def decode_halt(payload: bytes) -> Halt | None:
    """Read a request; None if it only asks.

    Raises:
        MessageError: it is none.
    """
    if not payload:
        return None
    if len(payload) > LIMIT:
        raise MessageError("oversize", f"halt request: {len(payload)} bytes, at most {LIMIT} are read")
    read = msgspec.json.decode if is_json(payload) else msgspec.msgpack.decode
    try:
        return read(payload, type=Halt)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise MessageError("shape", f"halt request: {error}") from None


def encode_halted(halted: Halted, request: bytes) -> bytes:
    """Payload of a reply, in the form of the request."""
    return msgspec.json.encode(halted) if is_json(request) else msgspec.msgpack.encode(halted)


def decode_halted(payload: bytes) -> Halted:
    """Read a reply; raises MessageError."""
    try:
        return msgspec.msgpack.decode(payload, type=Halted)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise MessageError("shape", f"reply to a halt request: {error}") from None
