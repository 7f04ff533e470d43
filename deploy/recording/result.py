"""The launcher's result, added to a recording after its recorder has finished."""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Mapping
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import DataEnd, Footer, McapRecord, Metadata, MetadataIndex, Statistics, SummaryOffset
from mcap.stream_reader import StreamReader
from mcap.writer import MCAP0_MAGIC

from deploy.recording.mcap.contents import records
from protocol.bus.drive import uninterrupted
from protocol.errors import RecordingError

LAUNCH = "launch"  # name of the metadata record


class _Tail(NamedTuple):
    """Where messages and metadata end, and the index that follows (empty for a file that was cut)."""

    place: int
    summary: list[McapRecord]


def attach(path: Path, result: Mapping[str, Any]) -> None:
    """Add the complete result of a run to its recording; a file that was cut gets a proper end by it.

    Raises:
        RecordingError: `path` is not a recording, or cannot be written.
    """
    data = path.read_bytes()
    if not data.startswith(MCAP0_MAGIC):
        raise RecordingError(f"{path} is not a recording: the result was not added")
    tail = _tail(data)
    try:
        with uninterrupted(), path.open("r+b") as file:  # or a finished recording would be a damaged one
            file.seek(tail.place)
            file.write(_rewritten(tail, Metadata(LAUNCH, {"json": json.dumps(result)})))
            file.truncate()
    except OSError as error:
        raise RecordingError(f"cannot add the result to {path}: {error.strerror}") from error


def _tail(data: bytes) -> _Tail:
    place = len(MCAP0_MAGIC)
    for opcode, start, end in records(data):
        if opcode == Opcode.DATA_END:
            return _Tail(start, _index(data[end:]))
        place = end
    return _Tail(place, [])


def _index(data: bytes) -> list[McapRecord]:
    """What stands between the data and the footer; none of it if the end is missing."""
    if not data.endswith(MCAP0_MAGIC):
        return []
    found = StreamReader(BytesIO(data), skip_magic=True).records
    return [record for record in found if not isinstance(record, Footer | SummaryOffset)]


def _rewritten(tail: _Tail, metadata: Metadata) -> bytes:
    """The metadata, and the end of the file after it."""
    body = _written([metadata])
    summary = b""
    start = tail.place + len(body) + len(_written([DataEnd(0)]))
    if tail.summary:
        index = [_counted(record) for record in tail.summary]
        summary = _written([*index, MetadataIndex(tail.place, len(body), metadata.name)])
    start = start if summary else 0
    head = struct.pack("<BQQQ", Opcode.FOOTER, 8 + 8 + 4, start, 0)
    footer = Footer(start, 0, zlib.crc32(head, zlib.crc32(summary)))
    return body + _written([DataEnd(0)]) + summary + _written([footer]) + MCAP0_MAGIC


def _counted(record: McapRecord) -> McapRecord:
    return (
        replace(record, metadata_count=record.metadata_count + 1)
        if isinstance(record, Statistics)
        else record
    )


def _written(records: list[McapRecord]) -> bytes:
    builder: Any = RecordBuilder()
    for record in records:
        record.write(builder)
    return bytes(builder.end())
