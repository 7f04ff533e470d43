"""Reading a peer's State: a robot gets the same as any other, except lines of other pairs."""

import math
from collections.abc import Callable
from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.peers.state import PeerReader, PeerState, addressed_to, plausible
from deploy.library.load import load
from protocol.codec import decode, encode
from protocol.errors import MessageError
from protocol.keys import STREAMS, robot_key
from protocol.messages import LARGEST, VERSION, Answer, Claim, Proposal, State

EPOCH = 2**31 + 7
ids = st.one_of(st.integers(1, 40), st.sampled_from((127, 128, 255, 256, 70_000, 999_999_999)))
counts = st.one_of(
    st.integers(0, 300), st.sampled_from((2**15, 2**16 - 1, 2**16, 2**31, 2**32 - 1, 2**32, 2**53))
)
numbers = st.floats(-1e3, 1e3)
sizes = st.floats(0.0, 1e3)
cosines = st.floats(-1.0, 1.0)
vectors = st.tuples(numbers, numbers)
proposals = st.lists(st.builds(Proposal, ids, counts, counts, cosines, cosines, numbers), max_size=18)
answers = st.lists(st.builds(Answer, ids, counts, counts, counts), max_size=18)
entries = proposals.map(tuple), answers.map(tuple)
places = st.one_of(st.none(), vectors)
states = st.builds(State, ids, counts, counts, places, *[sizes] * 3, vectors, st.just(EPOCH), *entries)


def fields(state: PeerState) -> dict[str, Any]:
    names = "robot incarnation tick placed x y bound gamma slice vx vy radius proposals answers"
    return {name: getattr(state, name) for name in names.split()}


def said(**other: Any) -> State:
    plain = State(1, 1, 7, (0.1, 0.2), 0.0, 1.0, 2.0, (0.0, 0.1))
    return msgspec.structs.replace(plain, **other)


@given(states, ids)
def test_it_is_what_the_state_says_to_this_robot(state: State, robot: int) -> None:
    whole = addressed_to(robot, state)
    assert fields(PeerReader(robot, state.robot, epoch=EPOCH).read(encode(state))) == fields(whole)


def outcome(read: Callable[[], PeerState]) -> str | dict[str, Any]:
    try:
        return fields(read())
    except MessageError as error:
        return error.reason


@given(states, ids, st.lists(st.tuples(st.integers(0, 400), st.integers(0, 255)), max_size=3), st.booleans())
def test_damage_is_seen_as_by_anybody_else(
    state: State, robot: int, spots: list[tuple[int, int]], short: bool
) -> None:
    payload = bytearray(encode(state))
    for place, byte in spots:
        payload[place % len(payload)] = byte
    payload = payload[: len(payload) - short]
    key = robot_key("demo", state.robot, "state")

    def whole() -> PeerState:
        message = decode(key, bytes(payload))
        if message.epoch != EPOCH:
            raise MessageError("epoch", "it is of another coordinator")
        return addressed_to(robot, message)

    found = outcome(lambda: PeerReader(robot, state.robot, epoch=EPOCH).read(bytes(payload)))
    expected = outcome(whole)
    assert found == expected


LIMITS = plausible(load("swap-4"))


@pytest.mark.parametrize(
    "lie",
    [
        {"gamma": 1e99},
        {"gamma": 1.01 * LIMITS.gamma},
        {"position": (1.01 * LIMITS.place, 0.0)},
        {"position": (0.0, -LARGEST)},
        {"bound": 1.01 * LIMITS.bound},
        {"slice": math.nan},
        {"desired": (0.0, 1e99)},
        {"proposals": (Proposal(2, 1, 1, 2.0, 0.0, 0.0),)},
        {"proposals": (Proposal(3, 1, 1, 1.0, 0.0, math.inf),)},
    ],
)
def test_what_one_refuses_all_refuse(lie: dict[str, Any]) -> None:
    for robot in (2, 3, 4):
        with pytest.raises(MessageError) as refused:
            PeerReader(robot, 1, limits=LIMITS).read(encode(said(**lie)))
        assert refused.value.reason == "shape"


def test_a_robot_does_not_claim_a_disk_that_no_part_makes() -> None:
    heard = PeerReader(2, 1, limits=LIMITS).read(encode(said(claim=Claim(1, 0.0, LARGEST))))
    heard.size(0.04)
    assert (heard.x, heard.radius) == (0.1, 0.04)


def changed(place: int, value: Any) -> bytes:
    """A State's array with something else at one place."""
    array = msgspec.msgpack.decode(encode(said()))
    array[place] = value
    return msgspec.msgpack.encode(array)


@pytest.mark.parametrize(
    ("payload", "reason"),
    [
        (encode(said()) + b"\x00", "shape"),
        (bytes(STREAMS["state"].limit + 1), "oversize"),
        (changed(0, "state/3"), "version"),
        (changed(9, 1), "epoch"),
        (changed(0, f"command/{VERSION}"), "type"),
        (changed(1, 9), "identity"),
    ],
)
def test_damage_is_refused_for_its_reason(payload: bytes, reason: str) -> None:
    with pytest.raises(MessageError) as refused:
        PeerReader(2, 1).read(payload)
    assert refused.value.reason == reason


@pytest.mark.parametrize(
    "unusual",
    [
        changed(5, 0),
        changed(8, (0, 0.1)),
        encode(said()).replace(b"\x07\x92", b"\xcf" + (7).to_bytes(8) + b"\x92", 1),
        encode(said()).replace(b"\x07\x92", b"\xcd\x00\x07\x92", 1),
    ],
)
def test_other_forms_of_the_same_are_read_too(unusual: bytes) -> None:
    assert unusual != encode(said())
    assert fields(PeerReader(2, 1).read(unusual)) == fields(addressed_to(2, said()))


def test_fields_of_a_later_minor_version_are_left_out() -> None:
    array = [*msgspec.msgpack.decode(encode(said(proposals=(Proposal(2, 1, 1, 1.0, 0.0, 0.5),)))), "new"]
    assert PeerReader(2, 1).read(msgspec.msgpack.encode(array)).proposals[0].offset == 0.5
    assert PeerReader(3, 1).read(msgspec.msgpack.encode(array)).tick == 7
