"""MCAP files read back: whole, cut, damaged, and in the order of time."""

import random
import struct
from contextlib import suppress
from io import BytesIO
from itertools import pairwise

import pytest
from mcap.exceptions import McapError
from mcap.records import Channel, Chunk, Message
from mcap.stream_reader import StreamReader
from mcap.writer import Writer

from deploy.telemetry.recording.reader import Contents, read
from protocol.errors import RecordingError, UsageError


def edges(data: bytes) -> list[tuple[int, bool]]:
    """Where each record ends, and whether it is a chunk."""
    stream = BytesIO(data)
    records = StreamReader(stream, emit_chunks=True).records
    return [(stream.tell(), isinstance(record, Chunk)) for record in records]


@pytest.mark.slow
def test_a_file_cut_anywhere_is_read_to_the_cut(recorded, tmp_path):
    """By this software and by stock tools; what is cut before the run began holds nothing, and says so."""
    whole = recorded[0].read_bytes()
    entries = list(read(recorded[0]).entries)
    ends = [end for end, _ in edges(whole)][::3]
    spread = range(0, len(whole), len(whole) // 40)
    places = sorted({0, 8, *ends, *(end + 5 for end in ends), *spread, len(whole) - 1} - {len(whole)})
    known = {repr(entry) for entry in entries}
    path, seen, best = tmp_path / "cut.mcap", 0, 0
    for place in places:
        path.write_bytes(whole[:place])
        try:
            found = read(path)
        except RecordingError as error:
            assert seen == 0, f"unreadable when cut at {place}, readable when cut before"
            assert "nothing was recorded" in str(error) or 0 < place < 8
            continue
        seen += 1
        assert found.cut
        kept = list(found.entries)
        assert len(kept) == found.counts.total() == stock(path) >= best
        best = len(kept)
        assert {repr(entry) for entry in kept} <= known
    assert seen > len(places) // 2
    assert best == len(entries)


def stock(path) -> int:
    """How many messages of the run the library finds in a cut file."""
    topics, found = {}, 0
    with path.open("rb") as file, suppress(McapError, struct.error):  # there is no end
        for record in StreamReader(file).records:
            if isinstance(record, Channel):
                topics[record.id] = record.topic
            elif isinstance(record, Message):
                found += not topics[record.channel_id].startswith("/")
    return found


def test_a_damaged_file_is_read_to_the_damage(recorded, tmp_path):
    data = bytearray(recorded[0].read_bytes())
    (start, _), (end, _) = [pair for pair in pairwise(edges(data)) if pair[1][1]][-1]
    data[(start + end) // 2] ^= 0xFF
    path = tmp_path / "damaged.mcap"
    path.write_bytes(data)
    found = read(path)
    assert found.cut
    assert found.counts.total() == len(list(found.entries)) < len(list(read(recorded[0]).entries))


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"PNG", "is not a recording"),
        (b"", "is empty: nothing was recorded"),
        (b"\x89MCAP0\r\n", "was cut before the run began; nothing was recorded"),
        (b"\x89MCAP0\r\n\1" + (2**60).to_bytes(8, "little"), "was cut before the run began"),
    ],
    ids=["foreign", "empty", "header only", "endless record"],
)
def test_what_holds_no_recording_says_so(tmp_path, content, said):
    path = tmp_path / "nothing.mcap"
    with pytest.raises(UsageError, match=r"nothing\.mcap: No such file"):
        read(path)
    path.write_bytes(content)
    with pytest.raises(RecordingError, match=said):
        read(path)


def test_a_whole_file_of_others_says_so(tmp_path):
    path = tmp_path / "other.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        writer.finish()
    with pytest.raises(RecordingError, match="holds no scenario: disknav did not write it"):
        read(path)


def test_messages_come_in_the_order_of_time_however_late_they_were_written(tmp_path):
    path, draw = tmp_path / "late.mcap", random.Random(7)
    times = [max(0, tick - draw.choice((0, 0, 0, 40, 900))) for tick in range(1000)]
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        number = writer.register_channel("topic", "json", 0)
        for index, time in enumerate(times):
            writer.add_message(number, time, b"%d" % index, time)
            if index % 70 == 0:
                writer.flush()
        writer.finish()
    found = Contents(path)
    assert [(time, int(data)) for _, time, data in found.messages()] == sorted(
        zip(times, range(1000), strict=True)
    )
    assert not found.cut
