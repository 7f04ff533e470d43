"""What stands in an MCAP file, up to where it ends or is damaged."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path

import zstandard
from mcap.exceptions import EndOfFile, McapError
from mcap.opcode import Opcode
from mcap.records import Channel, McapRecord, Message, Metadata
from mcap.stream_reader import StreamReader
from mcap.writer import MCAP0_MAGIC

from protocol.errors import RecordingError, UsageError

_HEAD = struct.Struct("<BQ")  # what every record begins with: opcode and length
_DAMAGE = (McapError, ValueError, RuntimeError, struct.error, zstandard.ZstdError, MemoryError)


@dataclass
class Contents:
    """Messages in the order of their log time, within one time as they were written.

    Attributes:
        cut: the file has no proper end, or is damaged: all before that place is here.
    """

    topics: dict[int, str] = field(default_factory=dict)
    messages: list[Message] = field(default_factory=list)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    cut: bool = False

    def add(self, record: McapRecord) -> None:
        """Take over one record."""
        if isinstance(record, Message):
            self.messages.append(record)
        elif isinstance(record, Channel):
            self.topics[record.id] = record.topic
        elif isinstance(record, Metadata):
            self.metadata[record.name] = record.metadata


def contents(path: Path) -> Contents:
    """Read an MCAP file, whole or cut.

    Raises:
        UsageError: it cannot be opened.
        RecordingError: it is not an MCAP file.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise UsageError(f"cannot read {path}: {error.strerror}") from error
    if not data.startswith(MCAP0_MAGIC):
        raise RecordingError(f"{path} is not a recording: name a file that `disknav run --record` wrote")
    end, ended = _complete(data)
    found = Contents(cut=not ended)
    try:
        for record in StreamReader(BytesIO(data[:end]), validate_crcs=True).records:
            found.add(record)
    except EndOfFile:
        pass  # the last complete record of a file that was cut
    except _DAMAGE:
        found.cut = True
    found.messages.sort(key=lambda message: message.log_time)
    return found


def records(data: bytes) -> Iterator[tuple[int, int, int]]:
    """Opcode, start and end of every record that is complete, the footer at most."""
    place = len(MCAP0_MAGIC)
    opcode = 0
    while opcode != Opcode.FOOTER and place + _HEAD.size <= len(data):
        opcode, length = _HEAD.unpack_from(data, place)
        end = place + _HEAD.size + length
        if end > len(data):
            return
        yield opcode, place, end
        place = end


def _complete(data: bytes) -> tuple[int, bool]:
    """Where the last complete record ends, and whether that is the file's proper end."""
    place = len(MCAP0_MAGIC)
    for opcode, start, end in records(data):
        if opcode == Opcode.FOOTER:
            after = end + len(MCAP0_MAGIC)
            return (after, True) if data[end:after] == MCAP0_MAGIC else (start, False)
        place = end
    return place, False
