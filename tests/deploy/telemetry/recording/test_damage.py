"""What is left of a file that was cut or damaged."""

import struct
from io import BytesIO

import pytest

from deploy.telemetry.recording.mcap.contents import records
from deploy.telemetry.recording.reading.reader import read
from protocol.errors import RecordingError, UsageError


@pytest.mark.slow
def test_a_file_cut_anywhere_is_read_to_the_cut(recorded, tmp_path):
    whole = recorded[0].read_bytes()
    entries = list(read(recorded[0]).entries)
    edges = [place for _, start, end in records(BytesIO(whole)) for place in (start, start + 5, end - 1)]
    places = sorted({*edges[::3], *range(0, len(whole), max(1, len(whole) // 40)), len(whole) - 1})
    known = {repr(entry) for entry in entries}
    path, seen, best = tmp_path / "cut.mcap", 0, 0
    for place in places:
        path.write_bytes(whole[:place])
        try:
            found = read(path)
        except RecordingError:
            assert seen == 0, f"unreadable when cut at {place}, readable when cut before"
            continue
        seen += 1
        assert found.cut
        kept = list(found.entries)
        assert len(kept) == found.counts.total() >= best
        best = len(kept)
        assert {repr(entry) for entry in kept} <= known
    assert seen > len(places) // 2
    assert best == len(entries)


def test_a_damaged_file_is_read_to_the_damage(recorded, tmp_path):
    data = bytearray(recorded[0].read_bytes())
    chunks = [(start, end) for opcode, start, end in records(BytesIO(data)) if opcode == 6]
    start, end = chunks[-1]
    data[(start + end) // 2] ^= 0xFF
    path = tmp_path / "damaged.mcap"
    path.write_bytes(data)
    assert read(path).cut


def test_what_is_no_recording_says_so(tmp_path):
    nothing = tmp_path / "nothing.mcap"
    with pytest.raises(UsageError, match=r"nothing\.mcap: No such file"):
        read(nothing)
    nothing.write_bytes(b"PNG")
    with pytest.raises(RecordingError, match="is not a recording"):
        read(nothing)


def test_nothing_reads_past_the_end():
    assert list(records(BytesIO(b"\x89MCAP0\r\n" + struct.pack("<BQ", 5, 2**60)))) == []
