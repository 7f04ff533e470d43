"""Requests to join and to steer, and the replies that robots get."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from random import Random

import msgspec

from deploy.library.figures import crash
from protocol import joining
from protocol.codec import decode
from protocol.errors import MessageError
from protocol.messages import Health
from protocol.operations import Steer, decode_steer
from tests.campaigns.faults import fault_scenario
from tests.fuzz.mutation import damaged_message
from tests.fuzz.target import Target
from tests.fuzz.traffic import traffic


@cache
def requests() -> list[bytes]:
    health = decode(*traffic()["health"][-1])
    assert isinstance(health, Health)
    return [
        joining.encode_request(joining.Join(1, "5f3a", health)),
        joining.encode_request(joining.Join(999, "")),
    ]


@cache
def _replies() -> list[bytes]:
    replies = (
        joining.Admission(3, True, fault_scenario(2), {1: 1, 2: 3}),
        joining.Refusal("robot 9 is not in this run"),
        joining.Wait(0.2, "another process is joining"),
        joining.Finished("arrived"),
        joining.Overview(crash(0), False),
    )
    return list(map(joining.encode_reply, replies))


@cache
def steers() -> list[bytes]:
    return [msgspec.msgpack.encode(s) for s in (Steer(True, 3, 0.5), {"pause": False}, {"speed": 2}, {})]


def _requested(valid: Callable[[], list[bytes]]) -> Callable[[Random], bytes]:
    return lambda rng: damaged_message(rng.choice(valid()), rng.choice(valid()), rng)


def _read_request(payload: bytes) -> bool:
    join = joining.decode_request(1, payload)
    assert joining.decode_request(1, joining.encode_request(join)) == join
    return True


def _read_reply(payload: bytes) -> bool:
    joining.encode_reply(joining.decode_reply(payload))
    return True


def _read_steer(payload: bytes) -> bool:
    msgspec.msgpack.encode(decode_steer(payload))
    return True


JOINING = {
    "join": Target(_requested(requests), _read_request, MessageError, 10),
    "reply": Target(_requested(_replies), _read_reply, MessageError, 6),
    "steer": Target(_requested(steers), _read_steer, MessageError, 6),
}
