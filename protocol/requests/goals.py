"""Goals while a fleet runs: a request under `robot/<id>/goal`, which the world answers.

Requests and replies are maps, in msgpack or, for people and stock tools, in JSON; the reply comes in the form
of the request. `{"points": [[x, y], ...]}` sends the robot to these points one after another,
`{"points": []}` cancels what it is doing: it stays where it is. Besides `points` there may be `queue` (true:
go there after what is ahead already), `patrol` (true: begin anew after the last) and `within` (s of simulated
time, after which the robot gives up). An empty request asks how things stand. The reply has `accepted`,
`number` of the order, `text` (why not, or what to beware of) and `status`, a `GoalStatus` as on the wire or
nil. What comes of an order is published as `GoalStatus`.
"""

from __future__ import annotations

from typing import Annotated

import msgspec
from msgspec import Meta

from protocol.messages import Count, GoalStatus, Vector
from protocol.requests.form import read_request

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
        MessageError: it is no order.
    """
    if not payload:
        return None
    return read_request(payload, GoalOrder, "goal", LIMIT)
