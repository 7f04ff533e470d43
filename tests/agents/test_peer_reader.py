"""What a robot reads of a peer's State: the same as anybody would, but for lines of other pairs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.peer_reader import PeerReader
from agents.peer_state import PeerState, said_to
from protocol.codec import encode
from protocol.errors import MessageError
from protocol.messages import Answer, Proposal, State
from protocol.streams import STREAMS

RADIUS = 0.04
ids = st.one_of(st.integers(1, 40), st.sampled_from((127, 128, 255, 256, 70_000, 999_999_999)))
counts = st.one_of(st.integers(0, 300), st.just(2**53))
numbers = st.floats(-1e3, 1e3)
sizes = st.floats(0.0, 1e3)
vectors = st.tuples(numbers, numbers)
proposals = st.lists(st.builds(Proposal, ids, counts, counts, numbers, numbers, numbers), max_size=6)
answers = st.lists(st.builds(Answer, ids, counts, counts, counts), max_size=6)


def fields(state: PeerState) -> dict[str, Any]:
    names = (
        "robot",
        "incarnation",
        "tick",
        "placed",
        "x",
        "y",
        "bound",
        "gamma",
        "slice",
        "vx",
        "vy",
        "radius",
    )
    return {name: getattr(state, name) for name in (*names, "proposals", "answers")}


def said(lines: Sequence[Proposal] = (), replies: Sequence[Answer] = (), **other: Any) -> State:
    plain = {"robot": 1, "incarnation": 1, "tick": 7, "position": (0.1, 0.2), "bound": 0.0, "gamma": 1.0}
    rest = {"slice": 2.0, "desired": (0.0, 0.1), "proposals": tuple(lines), "answers": tuple(replies)}
    return State(**{**plain, **rest, **other})


@given(
    st.builds(
        State,
        ids,
        counts,
        counts,
        st.one_of(st.none(), vectors),
        sizes,
        sizes,
        sizes,
        vectors,
        proposals.map(tuple),
        answers.map(tuple),
    ),
    ids,
)
def test_it_is_what_the_state_says_to_this_robot(state: State, robot: int) -> None:
    whole = said_to(robot, state, RADIUS)
    read = PeerReader(robot, state.robot, RADIUS).read(encode(state))
    # Of the two kinds of lines one is void: an owner has nothing to answer, a follower nothing to propose.
    if state.robot < robot:
        assert fields(read) | {"answers": ()} == fields(whole) | {"answers": ()}
    else:
        assert fields(read) | {"proposals": ()} == fields(whole) | {"proposals": ()}


def test_what_is_said_to_others_is_not_looked_into() -> None:
    state = said([Proposal(3, 1, 1, math.nan, 0.0, 0.0)])
    assert PeerReader(2, 1, RADIUS).read(encode(state)).proposals == ()
    with pytest.raises(MessageError, match="infinite or not a number"):
        PeerReader(3, 1, RADIUS).read(encode(state))


def changed(place: int, value: Any) -> bytes:
    """A State's array with something else at one place."""
    array = msgspec.msgpack.decode(encode(said()))
    array[place] = value
    return msgspec.msgpack.encode(array)


@pytest.mark.parametrize(
    ("payload", "reason"),
    [
        (b"", "shape"),
        (encode(said())[:-1], "shape"),
        (encode(said()) + b"\x00", "shape"),
        (bytes(STREAMS["state"].limit + 1), "oversize"),
        (changed(0, "state/2"), "version"),
        (changed(0, "command/1"), "type"),
        (changed(1, 9), "identity"),
        (changed(1, 0), "shape"),
        (changed(4, (0.0, math.inf)), "not-finite"),
        (changed(5, -1.0), "shape"),
        (changed(8, (math.nan, 0.0)), "not-finite"),
        (changed(9, [[2, 1, 1, "n", 0.0, 0.0]]), "shape"),
        (changed(9, [[2, 1, 1, 1.0, 0.0, math.inf]]), "not-finite"),
    ],
)
def test_damage_is_refused_for_its_reason(payload: bytes, reason: str) -> None:
    with pytest.raises(MessageError) as refused:
        PeerReader(2, 1, RADIUS).read(payload)
    assert refused.value.reason == reason


def test_fields_of_a_later_minor_version_are_left_out() -> None:
    array = [*msgspec.msgpack.decode(encode(said([Proposal(2, 1, 1, 1.0, 0.0, 0.5)]))), "new"]
    assert PeerReader(2, 1, RADIUS).read(msgspec.msgpack.encode(array)).proposals[0].offset == 0.5
    assert PeerReader(3, 1, RADIUS).read(msgspec.msgpack.encode(array)).tick == 7
