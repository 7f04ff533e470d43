"""The codec: what is sent arrives unchanged, and nothing hostile gets past MessageError."""

import math
from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocol.codec import decode, encode
from protocol.errors import MessageError
from protocol.keys import ROBOT_STREAMS, STREAMS
from protocol.messages import VERSION, AnyMessage, Command, Tick
from tests.protocol.sample_messages import ANY, ids

messages = st.sampled_from(sorted(ANY)).flatmap(lambda name: ANY[name])


def key_of(message: AnyMessage) -> str:
    robot = getattr(message, "robot", None)
    where = "world" if robot is None else f"robot/{robot}"
    return f"disknav/test/{where}/{type(message).__name__.lower()}"


def a_key(stream: str) -> str:
    return f"disknav/test/robot/1/{stream}" if stream in ROBOT_STREAMS else f"disknav/test/world/{stream}"


def refused(key: str, payload: bytes) -> str | None:
    """The reason for which a payload is refused, None when it is accepted; no other error may come."""
    try:
        decode(key, payload)
    except MessageError as error:
        return error.reason if str(error) else "no text"
    return None


@given(messages)
def test_round_trip(message: AnyMessage) -> None:
    assert decode(key_of(message), encode(message)) == message


@given(st.one_of(ANY["tick"], ANY["command"]))
def test_a_sender_may_leave_out_the_last_fields_that_say_nothing(message: Tick | Command) -> None:
    whole = msgspec.msgpack.decode(encode(message))
    for default in reversed(type(message).__struct_defaults__):
        if whole[-1] != ([] if default == () else default):
            break
        whole.pop()
        assert decode(key_of(message), msgspec.msgpack.encode(whole)) == message


@given(messages, st.sampled_from([math.nan, math.inf, -math.inf, 1e31, -1e31]), st.data())
def test_a_number_that_is_not_finite(message: AnyMessage, bad: float, data: st.DataObject) -> None:
    content = msgspec.msgpack.decode(encode(message))
    places: list[tuple[Any, int]] = []

    def collect(array: list[Any]) -> None:
        for n, item in enumerate(array):
            if isinstance(item, float):
                places.append((array, n))
            elif isinstance(item, list):
                collect(item)

    collect(content)
    if places:
        array, n = data.draw(st.sampled_from(places))
        array[n] = bad
        assert refused(key_of(message), msgspec.msgpack.encode(content)) == "shape"


@given(messages, st.integers(0, 99))
def test_another_version_is_named_as_such(message: AnyMessage, version: int) -> None:
    content = msgspec.msgpack.decode(encode(message))
    content[0] = f"{type(message).__name__.lower()}/{version}"
    reason = refused(key_of(message), msgspec.msgpack.encode([*content, "a field of the future"]))
    assert reason == ("version" if version != VERSION else reason)


@given(messages, messages)
def test_another_type_is_refused(message: AnyMessage, other: AnyMessage) -> None:
    key, payload = key_of(message), encode(other)
    if type(message) is not type(other):
        assert refused(key, payload) == (
            "oversize" if len(payload) > STREAMS[key.rpartition("/")[2]].limit else "type"
        )


@given(messages.filter(lambda message: hasattr(message, "robot")), ids)
def test_a_foreign_id_is_refused(message: AnyMessage, robot: int) -> None:
    key = f"disknav/test/robot/{robot}/{type(message).__name__.lower()}"
    assert refused(key, encode(message)) == (None if robot == message.robot else "identity")  # type: ignore[union-attr]  # filtered


LISTED = [7, 2, [1.0, 0.0, 0.5]]


@pytest.mark.parametrize(
    "grants",
    [
        [10, 9, 8, None, []],
        [5, 9, 10, None, []],
        [5, 6, 6, None, [LISTED]],
        [5, 9, 8, None, [LISTED, LISTED]],
        [5, 9, 8, None, [[7, 2, None]]],
        [5, 9, 8, None, [[7, 2, [0.5, 0.0, 0.5]]]],
    ],
    ids=["life", "region", "binding", "twice", "without a place", "no unit normal"],
)
def test_grants_that_no_ledger_makes_are_refused(grants: list[Any]) -> None:
    *said, _ = msgspec.to_builtins(Tick(1, 1, 3, (1, 2)))
    for told, reason in (([5, 9, 8, None, [LISTED]], None), (grants, "shape")):
        assert refused(a_key("tick"), msgspec.msgpack.encode([*said, told])) == reason


@pytest.mark.parametrize(
    ("normal", "reason"), [((0.6, 0.8), None), ((0.5, 0.0), "shape"), ((1.0, 1.0), "shape")]
)
def test_a_first_line_that_the_ledger_could_not_pass_on_is_refused(
    normal: tuple[float, float], reason: str | None
) -> None:
    said = msgspec.to_builtins(Command(1, 1, 3, (0.0, 0.0)))
    said[Command.__struct_fields__.index("firsts") + 1] = [[7, *normal, 0.5]]
    assert refused(a_key("command"), msgspec.msgpack.encode(said)) == reason


@pytest.mark.parametrize("name", sorted(STREAMS))
def test_oversize_is_refused_unread(name: str) -> None:
    assert refused(a_key(name), b"\x90" * (STREAMS[name].limit + 1)) == "oversize"


@pytest.mark.parametrize("key", ["", "disknav/test/world/scenario", "disknav/test/robot/1/alive", "x/y"])
def test_keys_that_carry_no_messages(key: str) -> None:
    assert refused(key, b"\x90") == "key"
