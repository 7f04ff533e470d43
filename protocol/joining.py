"""How a robot joins a run: a request under its own `join` key, and the world's reply.

Both are msgpack maps: the request `{"session": text, "health": Health or nil, "epoch": number}`, the reply
one of five kinds by its `"reply"`. `"admitted"` has `incarnation`, `lockstep`, `scenario` (maps with the keys
of a scenario file), `grace` (time after which a lost world may return, s), `founded` (whether the run has
begun) and `epoch` (of the coordinator: Ticks and States of any other are refused); `"refused"` has `text`;
`"other run"` nothing; `"wait"` has `after`, s, and `text`; `"finished"` has `verdict`. The key alone names
the robot that asks, so that a router's access rules apply. A monitor's request under `world/scenario` is
answered by `"scenario"`, with `scenario`, `lockstep`, and `goals`, the `GoalStatus` of every robot with an
order.

`session` is chosen by the process (see `protocol.keys`), the same for all its requests and for its liveliness
token. A process that repeats its request, since a reply may be lost, is admitted as the same life, until
`health` reports that this life is over. It takes part in one run: its later requests have the `epoch` of its
newest admission, and only that coordinator and those that continue from it admit it.
"""

from __future__ import annotations

from typing import Annotated, Any

import msgspec
from msgspec import Meta

from protocol.bus.bus import Bus
from protocol.codec import DAMAGED, keeps_newest
from protocol.errors import BusError, MessageError
from protocol.keys import SESSION, STREAMS, world_key
from protocol.messages import Count, Epoch, GoalStatus, Health, Id, Size
from protocol.scenario.model import Scenario


class Join(msgspec.Struct, frozen=True):
    """A request under a robot's `join` key. `session` distinguishes two processes with one id."""

    robot: Id  # in the key, not in the payload
    session: Annotated[str, Meta(pattern=f"^{SESSION}$")]
    health: Health | None = None  # of the life that has ended
    epoch: Epoch = 0  # of the newest admission of this process; 0 before the first


class Admission(msgspec.Struct, frozen=True, tag="admitted", tag_field="reply"):
    """Admitted: the process's life, and the parameters of the run."""

    incarnation: Count
    lockstep: bool
    scenario: Scenario
    grace: Size = 0.0  # s after which a lost world may still return; 0 if it never does
    founded: bool = False  # whether the run has begun: a later process begins at its disk
    epoch: Epoch = 0  # of the coordinator: messages of any other are refused


class Refusal(msgspec.Struct, frozen=True, tag="refused", tag_field="reply"):
    """Not admitted, and another request will not help; `text` is the reason."""

    text: str


class OtherRun(msgspec.Struct, frozen=True, tag="other run", tag_field="reply"):
    """The process takes part in another run of this name, or in a later part of this one."""


class Wait(msgspec.Struct, frozen=True, tag="wait", tag_field="reply"):
    """Ask again in `after` seconds."""

    after: Size
    text: str = ""


class Finished(msgspec.Struct, frozen=True, tag="finished", tag_field="reply"):
    """The run is over, with this `verdict`: the process may end."""

    verdict: str


class Overview(msgspec.Struct, frozen=True, tag="scenario", tag_field="reply"):
    """For monitors; only a lock-step run can be steered."""

    scenario: Scenario
    lockstep: bool
    goals: tuple[GoalStatus, ...] = ()  # of robots with orders; all others have the scenario's


JoinReply = Admission | Refusal | OtherRun | Wait | Finished | Overview

LIMIT = 2 * STREAMS["health"].limit  # bytes of a request

_encode = msgspec.msgpack.encode
_request = msgspec.msgpack.Decoder(dict[str, Any])
_reply: msgspec.msgpack.Decoder[JoinReply] = msgspec.msgpack.Decoder(JoinReply)


def encode_request(join: Join) -> bytes:
    """Payload of a request."""
    return _encode({"session": join.session, "health": join.health, "epoch": join.epoch})


def decode_request(robot: Id, payload: bytes) -> Join:
    """Read a request that was made under the `join` key of `robot`; raises MessageError."""
    if len(payload) > LIMIT:
        raise MessageError("oversize", f"join request: {len(payload)} bytes, at most {LIMIT} are read")
    try:
        join = msgspec.convert(_request.decode(payload) | {"robot": robot}, Join)
    except DAMAGED as error:
        raise MessageError("shape", f"join request: {error}") from None
    if join.health is not None and join.health.robot != robot:
        raise MessageError("identity", f"join request of robot {robot}: health of {join.health.robot}")
    return join


@keeps_newest
def encode_reply(reply: JoinReply) -> bytes:
    """Payload of a reply, encoded once for all processes that receive it. A reply is never changed."""
    return _encode(reply)


def decode_reply(payload: bytes) -> JoinReply:
    """Read a reply; raises MessageError."""
    try:
        return _reply.decode(payload)
    except DAMAGED as error:
        raise MessageError("shape", f"reply to a join request: {error}") from None


def overview(bus: Bus, run: str, timeout: float) -> Overview | None:
    """The overview of a run's world; None without a valid answer within `timeout` s."""
    try:
        reply = decode_reply(bus.ask(world_key(run, "scenario"), b"", timeout)[0])
    except (BusError, MessageError):
        return None
    return reply if isinstance(reply, Overview) else None
