"""Requests to a fleet that is up: goals, robots and things that come and go, the stop; and their replies."""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from typing import Any

import msgspec

from protocol.errors import MessageError
from protocol.messages import GoalStatus, Member, Roster
from protocol.requests.fleet import FleetReply, decode_change
from protocol.requests.form import encode_reply, read_reply
from protocol.requests.goals import GoalReply, decode_order
from protocol.requests.halt import Halted, decode_halt
from protocol.requests.things import ThingReply, decode_thing_change
from tests.fuzz.mutation import damaged_bytes, damaged_message, damaged_text, damaged_tree
from tests.fuzz.target import Target

_ADD = {"add": {"id": 7, "radius": 0.04, "start": [0.1, 0.2], "goal": [0.0, 0.1]}}
_PLACE = {"place": {"center": [0.1, 0.2], "radius": 0.03}}
_REQUESTS: dict[str, tuple[Callable[[bytes], object], list[dict[str, Any]]]] = {
    "goal": (
        decode_order,
        [{"points": [[0.1, -0.05], [0.0, 0.0]], "queue": True}, {"points": []},
         {"points": [[0.0, 0.1]], "patrol": True, "within": 5.0}],
    ),
    "fleet": (decode_change, [_ADD, {"remove": 7}]),
    "halt": (decode_halt, [{"halt": True}, {"halt": False}]),
    "things": (decode_thing_change, [_PLACE, {"take": 1}]),
}  # fmt: skip
_STATUS = GoalStatus(3, 10, 1, "under way", (0.1, 0.2))
_REPLIES: list[msgspec.Struct] = [
    GoalReply(True, 1, "overlaps the goal of robot 2", _STATUS),
    FleetReply(False, Roster(4, (Member(1, "live", 1, 0.04),)), "no"),
    Halted(True, 7),
    ThingReply(True, 1),
]


def _draw_request(rng: Random) -> tuple[str, bytes]:
    name = rng.choice(tuple(_REQUESTS))
    valid = rng.choice(_REQUESTS[name][1])
    if rng.randrange(2):  # as people write it
        text = msgspec.json.encode(damaged_tree(valid, rng)).decode()
        return name, damaged_text(text, text, rng).encode(errors="surrogatepass") if rng.randrange(2) else (
            damaged_bytes(text.encode(), b"{}", rng)
        )
    return name, damaged_message(msgspec.msgpack.encode(valid), msgspec.msgpack.encode(_ADD), rng)


def _read_request(drawn: tuple[str, bytes]) -> bool:
    name, request = drawn
    decoded = _REQUESTS[name][0](request)
    if decoded is not None:
        assert repr(_REQUESTS[name][0](msgspec.msgpack.encode(decoded))) == repr(decoded)  # NaN is not NaN
    return True


def _draw_reply(rng: Random) -> tuple[int, bytes]:
    number = rng.randrange(len(_REPLIES))
    return number, damaged_message(
        encode_reply(_REPLIES[number], b""), encode_reply(rng.choice(_REPLIES), b""), rng
    )


def _read_reply(drawn: tuple[int, bytes]) -> bool:
    number, reply = drawn
    read_reply(reply, type(_REPLIES[number]), "fleet")
    return True


ORDERS = {
    "order": Target(_draw_request, _read_request, MessageError, 12),
    "outcome": Target(_draw_reply, _read_reply, MessageError, 4),
}
