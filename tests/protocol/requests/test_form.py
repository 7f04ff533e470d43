"""Requests say the same in JSON and in msgpack, and nothing that could not be passed on."""

from __future__ import annotations

import msgspec
import pytest

from protocol.errors import MessageError
from protocol.requests.fleet import decode_change

ADD = {"add": {"id": 7, "radius": 0.04, "start": [0.1, 0.2], "goal": [0, 0.1]}}


def test_both_forms_say_the_same() -> None:
    assert decode_change(msgspec.json.encode(ADD)) == decode_change(msgspec.msgpack.encode(ADD))


@pytest.mark.parametrize("digits", [20, 400, 5000])
def test_an_integer_that_no_message_can_carry_is_refused(digits: int) -> None:
    text = msgspec.json.encode(ADD).replace(b":7,", b":1" + digits * b"0" + b",")
    with pytest.raises(MessageError, match=r"fleet request: .*[Ii]nteger"):
        decode_change(text)
