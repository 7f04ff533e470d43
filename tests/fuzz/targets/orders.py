"""Operations on a running fleet, and their replies."""

from __future__ import annotations

from random import Random
from typing import Any

import msgspec

from protocol.errors import MessageError
from protocol.messages import GoalStatus, Member, Roster
from protocol.operations import Reply, decode_operation, decode_reply, encode_reply
from tests.fuzz.mutation import damaged_bytes, damaged_message, damaged_text, damaged_tree
from tests.fuzz.target import Target

_ADD = {"add": {"id": 7, "radius": 0.04, "start": [0.1, 0.2], "goal": [0.0, 0.1]}}
_REQUESTS: list[dict[str, Any]] = [
    {"goal": {"robot": 3, "points": [[0.1, -0.05], [0.0, 0.0]], "queue": True}},
    {"goal": {"robot": 3, "points": []}},
    {"goal": {"robot": 3, "points": [[0.0, 0.1]], "patrol": True, "within": 5.0}},
    _ADD,
    {"remove": 7},
    {"halt": True},
    {"place": {"center": [0.1, 0.2], "radius": 0.03}},
    {"take": 1},
]
_STATUS = GoalStatus(3, 10, 1, "under way", (0.1, 0.2))
_REPLIES = [
    Reply(True, 1, "overlaps the goal of robot 2", tick=10, goals=(_STATUS,)),
    Reply(
        False, text="no", tick=3, halted=True, moving=(2,), roster=Roster(4, (Member(1, 1, "live", 0.04),))
    ),
]


def _draw_request(rng: Random) -> bytes:
    valid = rng.choice(_REQUESTS)
    if rng.randrange(2):  # as people write it
        text = msgspec.json.encode(damaged_tree(valid, rng)).decode()
        if rng.randrange(2):
            return damaged_text(text, text, rng).encode(errors="surrogatepass")
        return damaged_bytes(text.encode(), b"{}", rng)
    return damaged_message(msgspec.msgpack.encode(valid), msgspec.msgpack.encode(_ADD), rng)


def _read_request(request: bytes) -> bool:
    decoded = decode_operation(request)
    if decoded is not None:
        assert decode_operation(msgspec.msgpack.encode(decoded)) == decoded
    return True


def _draw_reply(rng: Random) -> bytes:
    valid, other = rng.choice(_REPLIES), rng.choice(_REPLIES)
    return damaged_message(encode_reply(valid, b""), encode_reply(other, b""), rng)


def _read_reply(reply: bytes) -> bool:
    decode_reply(reply, Reply)
    return True


ORDERS = {
    "order": Target(_draw_request, _read_request, MessageError, 12),
    "outcome": Target(_draw_reply, _read_reply, MessageError, 4),
}
