"""Steering: pause, steps, speed; and nothing but declared errors on bad requests."""

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocol.errors import MessageError
from protocol.requests.steering import Steer, Steering, decode_steer


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
    steering.apply(Steer(speed=2.0))
    assert steering == Steering(paused=True, steps=3, speed=2.0)


def test_a_request_is_a_plain_map() -> None:
    assert decode_steer(msgspec.msgpack.encode({"pause": True, "speed": 0.5})) == Steer(pause=True, speed=0.5)


@given(st.binary(max_size=64))
def test_junk_is_refused(payload: bytes) -> None:
    try:
        decode_steer(payload)
    except MessageError as error:
        assert error.reason == "shape"


def test_negative_speed_is_refused() -> None:
    with pytest.raises(MessageError):
        decode_steer(msgspec.msgpack.encode({"speed": -1.0}))
