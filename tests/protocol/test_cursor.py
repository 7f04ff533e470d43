"""What a cursor reads is what msgpack means, and it stops at everything that it does not read."""

from __future__ import annotations

import msgpack
import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocol.cursor import Cursor

EDGES = (0, 127, 128, 255, 256, 2**15, 2**16 - 1, 2**16, 2**31, 2**32 - 1)


@given(st.one_of(st.sampled_from(EDGES), st.integers(0, 2**32 - 1)))
def test_counts(number: int) -> None:
    payload = msgpack.packb([number, number])
    cursor = Cursor(payload, 0)
    cursor.enter(2)
    assert (cursor.count(), cursor.count(), cursor.at) == (number, number, len(payload))


@given(st.floats(allow_nan=False))
def test_numbers(number: float) -> None:
    cursor = Cursor(msgpack.packb(number), 0)
    assert (cursor.number(), cursor.at) == (number, 9)


@given(st.integers(0, 300))
def test_arrays(elements: int) -> None:
    payload = msgpack.packb([None] * elements)
    cursor = Cursor(payload, 0)
    assert cursor.array() == elements
    assert all(cursor.none() for _ in range(elements))
    assert cursor.at == len(payload)


def test_what_is_not_nothing_remains_to_be_read() -> None:
    cursor = Cursor(b"\x07", 0)
    assert not cursor.none()
    assert cursor.count() == 7


@pytest.mark.parametrize("wrong", [-1, 2**32, 1.0, None, "1", b"1", [], {}, True])
def test_no_count(wrong: object) -> None:
    with pytest.raises(IndexError):
        Cursor(msgpack.packb(wrong), 0).count()


@pytest.mark.parametrize("wrong", [1, None, "1", [1.0], False])
def test_no_number(wrong: object) -> None:
    with pytest.raises(IndexError):
        Cursor(msgpack.packb(wrong), 0).number()


@pytest.mark.parametrize("wrong", [1, None, "12", {1: 2}, [1], [1, 2, 3], [0] * 70_000])
def test_no_pair(wrong: object) -> None:
    with pytest.raises(IndexError):
        Cursor(msgpack.packb(wrong), 0).enter(2)


@given(st.one_of(st.sampled_from(EDGES[2:]), st.floats(), st.just([0] * 16)), st.data())
def test_what_is_cut_off(value: object, data: st.DataObject) -> None:
    payload = msgpack.packb(value)
    short = payload[: data.draw(st.integers(0, min(8, len(payload) - 1)))]
    for read in (Cursor.count, Cursor.number):
        with pytest.raises(IndexError):
            read(Cursor(short, 0))
    with pytest.raises(IndexError):
        Cursor(short[:2], 0).array()
