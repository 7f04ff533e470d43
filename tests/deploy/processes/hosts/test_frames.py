"""Messages of a host that stalls, ends, or sends what it likes."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import suppress
from itertools import pairwise
from multiprocessing.connection import Connection as Channel
from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from deploy.processes.hosts.ssh import Frames
from deploy.processes.spawn import Exited, decode_news, encode_news
from tests.world.stopwatch import Stopwatch

PATIENCE = 5.0


class Line:
    """One way from a host to this process."""

    def __init__(self) -> None:
        self.reading, self.writing = os.pipe()
        self.clock = Stopwatch()
        self.frames = Frames(self.reading, 1000, PATIENCE, self.clock)

    def arrives(self, payload: bytes) -> list[bytes]:
        os.write(self.writing, payload)
        return list(self.frames.read(0.0))


@pytest.fixture
def line() -> Iterator[Line]:
    it = Line()
    yield it
    for descriptor in (it.reading, it.writing):
        with suppress(OSError):  # some tests close one
            os.close(descriptor)


def framed(message: bytes) -> bytes:
    """As a host's channel writes it."""
    reading, writing = os.pipe()
    channel: Channel[Any, Any] = Channel(writing, readable=False)
    channel.send_bytes(message)
    channel.close()
    with os.fdopen(reading, "rb") as file:
        return file.read()


@given(st.lists(st.binary(max_size=100), max_size=5), st.lists(st.integers(0, 600), max_size=6))
def test_messages_come_whole_wherever_they_are_cut(messages: list[bytes], cuts: list[int]) -> None:
    it = Line()
    stream = b"".join(map(framed, messages))
    places = sorted({0, len(stream), *(cut for cut in cuts if cut < len(stream))})
    found: list[bytes] = []
    for begin, end in pairwise(places):
        found += it.arrives(stream[begin:end])
        it.clock.now += 0.9 * PATIENCE / 7
    assert found == messages
    os.close(it.reading)
    os.close(it.writing)


def test_whoever_stalls_in_the_middle_of_a_message_is_given_up_within_the_bound(line: Line) -> None:
    stream = framed(b"well") + framed(b"half a message")[:-3]
    assert line.arrives(stream) == [b"well"]
    line.clock.now = PATIENCE
    assert line.arrives(b"") == []
    line.clock.now = PATIENCE + 0.1
    with pytest.raises(ValueError, match="stalled in the middle of a message"):
        line.arrives(b"")


def test_silence_between_messages_is_no_stall(line: Line) -> None:
    for _ in range(3):
        assert line.arrives(framed(b"well")) == [b"well"]
        line.clock.now += 100.0 * PATIENCE
        assert line.arrives(b"") == []


@pytest.mark.parametrize(
    "garbage", [b"\xff\xff\xff\xff", b"\x7f\xff\xff\xff", b"GET / HTTP/1.1", b"\0\0\x03\xe9"]
)
def test_what_is_no_message_is_refused_before_it_is_kept(line: Line, garbage: bytes) -> None:
    with pytest.raises(ValueError, match="a message of"):
        line.arrives(garbage)


def test_a_host_that_never_stops_talking_leaves_time_for_others(line: Line) -> None:
    stream = framed(b"") * 2000
    assert 0 < len(line.arrives(stream)) < 300


def test_the_end_is_the_end(line: Line) -> None:
    os.close(line.writing)
    with pytest.raises(EOFError):
        list(line.frames.read(0.0))


@pytest.mark.parametrize(
    "lie",
    [
        {"code": -65},
        {"code": 1 << 40},
        {"cpu_s": float("nan")},
        {"cpu_s": -1.0},
        {"max_rss_mb": float("inf")},
    ],
)
def test_news_that_cannot_be_are_refused(lie: dict[str, Any]) -> None:
    true: dict[str, Any] = {"code": 0, "cpu_s": 1.0, "max_rss_mb": 50.0}
    assert decode_news(encode_news(Exited(1, **true))) == Exited(1, **true)
    with pytest.raises(msgspec.DecodeError):
        decode_news(encode_news(Exited(1, **{**true, **lie})))
