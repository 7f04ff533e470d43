"""The emergency stop: a request under `world/halt`, which the world answers.

`{"halt": true}` has all robots brake in the present tick, bases outside in the next, and stand;
`{"halt": false}` releases them; an empty request asks for the state. The reply has `halted`, the present
`tick`, `moving`, the robots that do not stand yet, and `text`, why a release has no effect. A stop has
succeeded once `halted` is true and `moving` is empty. Maps in msgpack, or JSON text; the reply comes in the
form of the request. Robots go on talking about their lines meanwhile, and a robot that is not released does
not move, whatever is commanded.
"""

from __future__ import annotations

import msgspec

from protocol.messages import Count, Id
from protocol.requests.form import read_request

LIMIT = 1024  # bytes of a request


class Halt(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What is asked."""

    halt: bool


class Halted(msgspec.Struct, frozen=True):
    """The state of the emergency stop.

    Attributes:
        halted: whether it is in force.
        tick: the first in which that is so, or the present one.
        moving: robots that do not stand yet; empty unless it is in force.
        text: why it is in force although nobody asked for it.
    """

    halted: bool
    tick: Count
    moving: tuple[Id, ...] = ()
    text: str = ""


def decode_halt(payload: bytes) -> Halt | None:
    """Read a request; None if it only asks.

    Raises:
        MessageError: it is none.
    """
    return read_request(payload, Halt, "halt", LIMIT) if payload else None
