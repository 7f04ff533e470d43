"""The emergency stop: a request under `world/halt`, which the world answers.

`{"halt": true}` has everybody brake in the present tick, bases outside in the next, and stand;
`{"halt": false}` releases them; an empty request asks how things stand. The reply has `halted` and the
present `tick`. Maps in msgpack, or JSON text; the reply comes in the form of the request. Robots go on
talking about their lines meanwhile, and a robot that is not released does not move, whoever commands it.
"""

from __future__ import annotations

import msgspec

from protocol.messages import Count
from protocol.requests.form import read_request

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
    return read_request(payload, Halt, "halt", LIMIT) if payload else None
