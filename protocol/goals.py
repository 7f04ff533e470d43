"""Goals while a fleet runs: a request under `robot/<id>/goal`, which the world answers.

Requests and replies are maps, in msgpack or, for people and stock tools, in JSON; the reply comes in the form
of the request. `{"points": [[x, y], ...]}` sends the robot to these points one after another,
`{"points": []}` cancels what it is doing: it stays where it is. An empty request asks how things stand.
What comes of an order is published as `GoalStatus`.
"""

from __future__ import annotations

import math
from typing import Annotated

import msgspec
from msgspec import Meta

from protocol.errors import MessageError
from protocol.messages import Count, GoalStatus, Vector

LIMIT = 16 * 1024  # bytes of a request
MOST_POINTS = 512  # of one robot, those ahead of earlier orders included


class GoalOrder(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Where a robot is to go.

    Attributes:
        points: m, in this order; none cancels.
        queue: go there after what is ahead already, instead of at once.
        patrol: begin anew with the first of all points after the last.
        within: s of simulated time after which the robot gives up and stays where it is.
    """

    points: Annotated[tuple[Vector, ...], Meta(max_length=MOST_POINTS)]
    queue: bool = False
    patrol: bool = False
    within: Annotated[float, Meta(gt=0, le=1e6)] | None = None


class GoalReply(msgspec.Struct, frozen=True):
    """Whether an order was accepted.

    Attributes:
        number: of the order, as its status names it; 0 if it was refused.
        text: why it was refused, or what to beware of.
        status: how things stand now.
    """

    accepted: bool
    number: Count = 0
    text: str = ""
    status: GoalStatus | None = None


def decode_order(payload: bytes) -> GoalOrder | None:
    """Read a request; None if it only asks how things stand.

    Raises:
        MessageError: it is no order, or holds a number that is infinite or none.
    """
    if not payload:
        return None
    if len(payload) > LIMIT:
        raise MessageError("oversize", f"goal request: {len(payload)} bytes, at most {LIMIT} are read")
    read = msgspec.json.decode if is_json(payload) else msgspec.msgpack.decode
    try:
        order = read(payload, type=GoalOrder)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise MessageError("shape", f"goal request: {error}") from None
    if not all(math.isfinite(part) for point in order.points for part in point):
        raise MessageError("not-finite", "goal request: a point holds a number that is infinite or none")
    return order


def encode_reply(reply: GoalReply, request: bytes) -> bytes:
    """Payload of a reply, in the form of the request."""
    return msgspec.json.encode(reply) if is_json(request) else msgspec.msgpack.encode(reply)


def decode_reply(payload: bytes) -> GoalReply:
    """Read a reply; raises MessageError."""
    try:
        return msgspec.msgpack.decode(payload, type=GoalReply)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise MessageError("shape", f"reply to a goal request: {error}") from None


def is_json(payload: bytes) -> bool:
    """Whether a request is JSON text; no map in msgpack begins like that."""
    return payload[:1] in (b"{", b" ", b"\n", b"\t")
