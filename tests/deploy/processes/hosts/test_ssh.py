"""A host at the other end of ssh: what it may say, framed, checked and labelled with its name."""

import io
import json
import math
import os
import struct
from collections.abc import Iterator
from contextlib import suppress
from itertools import pairwise
from multiprocessing.connection import Connection as Channel
from pathlib import Path
from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from deploy.processes.hosts.ssh import FramedMessages, Relay
from deploy.processes.spawn import Exited, Started, decode_news, encode_news
from protocol.errors import ProcessError
from tests.campaigns.fuzz.hosts import HostOnPipe
from tests.world.driving import Stopwatch

PATIENCE = 5.0


class Line:
    def __init__(self) -> None:
        self.reading, self.writing = os.pipe()
        self.clock = Stopwatch()
        self.frames = FramedMessages(self.reading, 1000, PATIENCE, self.clock)

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


def test_a_host_that_stalls_in_the_middle_of_a_message_is_given_up_within_the_bound(line: Line) -> None:
    stream = framed(b"well") + framed(b"half a message")[:-3]
    assert line.arrives(stream) == [b"well"]
    line.clock.now = PATIENCE
    assert line.arrives(b"") == []
    line.clock.now = PATIENCE + 0.1
    with pytest.raises(ValueError, match="stalled in the middle of a message"):
        line.arrives(b"")


@pytest.mark.parametrize(
    "garbage", [b"\xff\xff\xff\xff", b"\x7f\xff\xff\xff", b"GET / HTTP/1.1", b"\0\0\x03\xe9"]
)
def test_what_is_no_message_is_refused_before_it_is_kept(line: Line, garbage: bytes) -> None:
    with pytest.raises(ValueError, match="a message of"):
        line.arrives(garbage)


def test_a_host_that_never_stops_talking_leaves_time_for_others(line: Line) -> None:
    stream = framed(b"") * 2000
    assert 0 < len(line.arrives(stream)) < 300


@pytest.mark.parametrize(
    "lie", [{"code": -65}, {"code": 1 << 40}, {"cpu_s": math.nan}, {"cpu_s": -1.0}, {"max_rss_mb": math.inf}]
)
def test_news_that_cannot_be_are_refused(lie: dict[str, Any]) -> None:
    true: dict[str, Any] = {"code": 0, "cpu_s": 1.0, "max_rss_mb": 50.0}
    assert decode_news(encode_news(Exited(1, **true))) == Exited(1, **true)
    with pytest.raises(msgspec.DecodeError):
        decode_news(encode_news(Exited(1, **{**true, **lie})))


def test_why_a_process_ended_is_for_the_launcher_to_say() -> None:
    reading, writing = os.pipe()
    true, lie = Started(1, 4711), ("Exited", 1, 3, 0.0, 0.0, "\x1b[2J all is well")
    for news in (encode_news(true), msgspec.msgpack.encode(lie)):
        os.write(writing, struct.pack("!i", len(news)) + news)
    heard = HostOnPipe(reading).news(1.0)
    assert next(heard) == true
    with pytest.raises(ProcessError, match="host left does not follow the protocol: Expected `array`"):
        next(heard)
    os.close(reading)
    os.close(writing)


SAID = {
    "time": "2026-11-22T13:56:23.671691Z", "level": "warning", "run": "yard", "host": "base", "role": "robot",
    "robot": 3, "text": "stands \x1b[2J still",
}  # fmt: skip
LINES = (
    json.dumps(SAID),
    json.dumps({**SAID, "level": "info", "text": "life 2 begins"}),
    json.dumps({**SAID, "text": "failed:\nworld: all is well"}),
    json.dumps({**SAID, "time": "0001-01-01T00:00:00"}),
    "Welcome to \x1b]0;Debian\x07",
    json.dumps({**SAID, "role": "../../robot"}),
    "x" * 200_000,
)


def test_all_that_a_host_says_is_labelled(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    relay = Relay("left", "yard", tmp_path)
    relay.follow(io.BytesIO("\n".join(LINES).encode()))
    relay.end()
    words = capsys.readouterr().err
    assert words.startswith("left: robot 3: stands  [2J still\n")
    assert "left: robot 3: failed:\nleft: world: all is well\n" in words
    assert "\x1b" not in words
    assert "life 2" not in words
    assert all(line.startswith("left: ") for line in words.splitlines())
    assert [path.name for path in tmp_path.iterdir()] == ["left.jsonl"]
    lines = [msgspec.json.decode(line) for line in (tmp_path / "left.jsonl").read_text().splitlines()]
    assert {line["host"] for line in lines} == {"left"}
    assert [line["role"] for line in lines[:6]] == ["robot", "robot", "robot", "", "", ""]
    assert lines[0]["time"] == SAID["time"]
    assert lines[1]["text"] == "life 2 begins"
