"""The MCAP file says what the `mcap` library's own writer says, and its indexes lead to the messages."""

import random
import struct
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.records import ChunkIndex, McapRecord, Message, MessageIndex, Statistics
from mcap.stream_reader import StreamReader, get_chunk_data_stream
from mcap.writer import CompressionType, Writer

from deploy.telemetry.recording.mcap.contents import contents
from deploy.telemetry.recording.mcap.file import McapFile

CHANNELS = 5
_HEAD = struct.Struct("<BQHIQQ")


def said(count: int) -> list[tuple[int, int, bytes]]:
    """Channel, time and content of messages, in no order of time."""
    draw = random.Random(count)
    return [
        (draw.randint(1, CHANNELS), draw.randrange(2**40), b"{%s}" % (b" " * draw.randrange(300)))
        for _ in range(count)
    ]


@pytest.fixture(scope="module", params=[0, 1, 7, 5000])
def both(request, tmp_path_factory):
    """Our file, the library's, and how many messages they hold."""
    folder, messages = tmp_path_factory.mktemp("mcap"), said(request.param)
    ours, theirs = folder / "ours.mcap", folder / "theirs.mcap"
    _write(ours, messages)
    _write_by_library(theirs, messages)
    return ours, theirs, len(messages)


def _write(path: Path, messages: list[tuple[int, int, bytes]]) -> None:
    file = McapFile(path, "test")
    file.metadata("before", {"a": "1"})
    schema = file.schema("s", b"{}")
    for number in range(1, CHANNELS + 1):
        assert file.channel(f"c{number}", schema, {"rate": "r"}) == number
    for start in range(0, len(messages), 700):
        channels, times, data = zip(*messages[start : start + 700], strict=True)
        file.messages(channels, np.array(times, np.uint64), b"".join(each + b"\n" for each in data))
        if start % 1400:
            file.flush()
    file.metadata("after", {"b": "2"})
    file.finish({})


def _write_by_library(path: Path, messages: list[tuple[int, int, bytes]]) -> None:
    with path.open("wb") as file:
        writer = Writer(file, compression=CompressionType.ZSTD)
        writer.start("", "test")
        writer.add_metadata("before", {"a": "1"})
        schema = writer.register_schema("s", "jsonschema", b"{}")
        for number in range(1, CHANNELS + 1):
            writer.register_channel(f"c{number}", "json", schema, {"rate": "r"})
        counts = [0] * (CHANNELS + 1)
        for channel, when, data in messages:
            writer.add_message(channel, when, data, when, counts[channel])
            counts[channel] += 1
        writer.add_metadata("after", {"b": "2"})
        writer.finish()


def test_the_same_records_as_the_library_writes(both):
    ours, theirs, count = both
    with ours.open("rb") as mine, theirs.open("rb") as other:
        one, two = make_reader(mine, validate_crcs=True), make_reader(other, validate_crcs=True)
        messages = list(one.iter_messages())
        assert messages == list(two.iter_messages())
        assert len(messages) == count
        assert list(one.iter_metadata()) == list(two.iter_metadata())
        here, there = one.get_summary(), two.get_summary()
        assert (here.schemas, here.channels) == (there.schemas, there.channels)
        assert _comparable(here.statistics) == _comparable(there.statistics)


def test_the_order_in_the_file_is_that_of_writing(both):
    ours, _, count = both
    found = [each for each in StreamReader(BytesIO(ours.read_bytes())).records if isinstance(each, Message)]
    assert [(each.channel_id, each.log_time, each.data) for each in found] == said(count)


def test_indexes_lead_to_the_messages(both):
    ours, _, count = both
    data = ours.read_bytes()
    with ours.open("rb") as file:
        chunks = make_reader(file).get_summary().chunk_indexes
    assert sum(_check_chunk(data, chunk) for chunk in chunks) == count


def _check_chunk(data: bytes, chunk: ChunkIndex) -> int:
    """Follow every entry of its message indexes; returns how many there are."""
    record = _first(data, chunk.chunk_start_offset)
    stream, _ = get_chunk_data_stream(record, validate_crc=True)
    body = stream.read(chunk.uncompressed_size)
    times = []
    for channel, place in chunk.message_index_offsets.items():
        index = _first(data, place)
        assert isinstance(index, MessageIndex)
        assert index.channel_id == channel
        for when, offset in index.records:
            head = _HEAD.unpack_from(body, offset)
            assert (head[0], head[2], head[4], head[5]) == (5, channel, when, when)
            times.append(when)
    assert (min(times, default=0), max(times, default=0)) == (
        chunk.message_start_time,
        chunk.message_end_time,
    )
    return len(times)


def _first(data: bytes, place: int) -> McapRecord:
    """The record that begins at `place`."""
    return next(iter(StreamReader(BytesIO(data[place:]), skip_magic=True, emit_chunks=True).records))


def _comparable(statistics: Statistics) -> dict:
    """All but how the messages were spread over chunks."""
    return {**vars(statistics), "chunk_count": None}


def test_messages_come_in_the_order_of_time_however_late_they_were_written(tmp_path):
    file, draw = McapFile(tmp_path / "late.mcap", "test"), random.Random(7)
    number = file.channel("topic", file.schema("any", b"{}"), {})
    times = [max(0, tick - draw.choice((0, 0, 0, 40, 900))) for tick in range(1000)]
    for index, time in enumerate(times):
        file.messages([number], np.array([time], np.uint64), b"%d\n" % index)
        if index % 70 == 0:
            file.flush()
    file.finish({})
    said = [(each.log_time, int(each.data)) for each in contents(tmp_path / "late.mcap").messages()]
    assert said == sorted(zip(times, range(1000), strict=True))
