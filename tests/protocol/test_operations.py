"""Requests to a running fleet: one form in JSON, msgpack and scenario files, and declared errors only."""

from typing import Any

import msgspec
import pytest

from protocol.errors import MessageError
from protocol.messages import GoalStatus, Member, Roster
from protocol.operations import (
    LIMIT,
    Reply,
    Steer,
    Steering,
    decode_operation,
    decode_reply,
    decode_steer,
    encode_reply,
    is_json,
)
from protocol.scenario.file import parse_document
from protocol.scenario.model import Journey, Obstacle, Operation, RobotSpec

GUEST = {"id": 7, "radius": 0.04, "start": [0.1, 0.2], "goal": [0.0, 0.1]}
ROOM = {
    "workspace": {"radius": 2.0},
    "robots": [{"id": n, "radius": 0.04, "start": [n / 2, 0.0], "goal": [n / 2, 0.0]} for n in (1, 2)],
    "obstacles": [{"center": [1.0, 1.0], "radius": 0.1}],
}
ASKED: list[tuple[dict[str, Any], Operation]] = [
    (
        {"goal": {"robot": 1, "points": [[0.1, -0.2]], "queue": True}},
        Operation(goal=Journey(1, ((0.1, -0.2),), queue=True)),
    ),
    ({"goal": {"robot": 1}}, Operation(goal=Journey(1))),
    (
        {"goal": {"robot": 1, "points": [[0.0, 0.1]], "patrol": True, "within": 5.0}},
        Operation(goal=Journey(1, ((0.0, 0.1),), patrol=True, within=5.0)),
    ),
    ({"add": GUEST}, Operation(add=RobotSpec(7, 0.04, (0.1, 0.2), (0.0, 0.1)))),
    ({"remove": 2}, Operation(remove=2)),
    ({"place": {"center": [0.1, 0.2], "radius": 0.03}}, Operation(place=Obstacle((0.1, 0.2), 0.03))),
    ({"take": 1}, Operation(take=1)),
    ({"halt": False}, Operation(halt=False)),
]


@pytest.mark.parametrize(("asked", "operation"), ASKED)
def test_an_operation_reads_the_same_from_every_form(asked: dict[str, Any], operation: Operation) -> None:
    assert decode_operation(msgspec.json.encode(asked)) == operation
    assert decode_operation(msgspec.msgpack.encode(asked)) == operation
    assert decode_operation(msgspec.msgpack.encode(operation)) == operation
    (order,) = parse_document(ROOM | {"orders": [{"at": 1.0, **asked}]}).orders
    assert (order.asked, str(order)) == (operation.asked, str(operation))
    assert all(getattr(order, action) == getattr(operation, action) for action in order.asked)


@pytest.mark.parametrize(
    ("payload", "words"),
    [
        (b"{}", "name exactly one of"),
        (b'{"take": 1, "remove": 2}', "not remove and take"),
        (b'{"tak": 99}', "did you mean `take`"),
        (b'{"take": 0}', "must be at least 1"),
        (b'{"halt": 1}', "must be true or false"),
        (b'{"place": 3}', "must be a table"),
        (b'{"goal": {"robot": 1, "points": [[0, NaN]]}}', "JSON"),
        (b'{"goal": {"robot": 1, "points": [[0, 1]], "patrole": true}}', "did you mean `patrol`"),
        (b'{"goal": {"robot": 1, "points": [[0, 1]], "within": 0}}', "within: must be at least"),
        (b'{"goal": {"robot": 1, "points": [[0, 1e9]]}}', "points[0][1]: must be at most"),
        (b"\xc1", "operation"),
        (b"\x91\x01", "must be a map"),
        (b"\x81\x01\x02", "unknown key"),
        (b"{", "operation"),
        (b"{" * 10_000, "operation"),
        (msgspec.msgpack.encode({"goal": {"robot": 1, "points": [[0.0, float("nan")]]}}), "finite"),
        *((b'{"remove": 1' + digits * b"0" + b"}", "operation") for digits in (20, 400, 5000)),
    ],
)
def test_a_malformed_operation_is_refused_with_its_reason(payload: bytes, words: str) -> None:
    with pytest.raises(MessageError) as raised:
        decode_operation(payload)
    assert raised.value.reason == "shape"
    assert words in str(raised.value)


def test_an_empty_request_asks_for_the_state_and_an_oversize_one_is_not_read() -> None:
    assert decode_operation(b"") is None
    with pytest.raises(MessageError, match="at most") as raised:
        decode_operation(b" " * (LIMIT + 1))
    assert raised.value.reason == "oversize"


def test_a_reply_is_in_the_form_of_its_request() -> None:
    status = GoalStatus(3, 10, 1, "under way", (0.1, 0.2))
    reply = Reply(True, 4, tick=10, roster=Roster(4, (Member(1, 1, "live", 0.04),)), goals=(status,))
    assert is_json(encode_reply(reply, b'{"take": 1}'))
    assert decode_reply(encode_reply(reply, b""), Reply) == reply
    assert (reply.goal(3), reply.goal(4)) == (status, None)


def test_paused_ticks_happen_step_by_step() -> None:
    steering = Steering()
    assert steering.allow()
    steering.apply(Steer(pause=True))
    assert not steering.allow()
    steering.apply(Steer(step=2))
    assert [steering.allow() for _ in range(3)] == [True, True, False]
    steering.apply(Steer(pause=False))
    assert steering.allow()
    assert steering.allow()


def test_a_request_changes_only_what_it_names() -> None:
    steering = Steering(paused=True, steps=3)
    steering.apply(decode_steer(msgspec.msgpack.encode({"speed": 2.0})))
    assert steering == Steering(paused=True, steps=3, speed=2.0)
    with pytest.raises(MessageError, match="speed: must be at least 0"):
        decode_steer(msgspec.msgpack.encode({"speed": -1.0}))
