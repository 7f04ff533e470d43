"""An MCAP file that is being written: the records are the `mcap` library's, the messages packed at once.

The library's own writer takes ten times as long for a message as its JSON does, a field at a time; a
recorder that shares two processors with a fleet cannot afford that.
"""

from __future__ import annotations

import struct
import zlib
from collections import defaultdict
from pathlib import Path
from typing import Any, BinaryIO

import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
)
from mcap.writer import MCAP0_MAGIC

_CHUNK = 256 * 1024  # bytes before compression; what one damaged place in the file can cost
_LEVEL = 1  # of compression, the fastest: for messages so much alike as small as the default
_MESSAGE = struct.Struct("<BQHIQQ")  # opcode, length, channel, sequence, log time, publish time
_OPCODE = int(Opcode.MESSAGE)
_LENGTH = _MESSAGE.size - 9  # of a message without its data and without opcode and length
_INDEX = struct.Struct("<BQHI")  # opcode, length, channel, bytes of the entries


class McapFile:
    """Messages in chunks compressed with zstd, each chunk and kind of record indexed at the end.

    Raises:
        OSError: (all methods) the file cannot be written.
    """

    def __init__(self, path: Path, library: str) -> None:
        self._file: BinaryIO = path.open("wb")
        self._place = 0
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._chunks: list[ChunkIndex] = []
        self._metadata: list[MetadataIndex] = []
        self._counts: list[int] = [0]  # messages by channel, closed chunks only; channels count from 1
        self._clear()
        self._put(MCAP0_MAGIC + packed(Header("", library)))

    def _clear(self) -> None:
        """Begin another chunk."""
        self._parts: list[bytes] = []
        self._size = 0
        self._entries: defaultdict[int, list[int]] = defaultdict(list)  # time, offset, time, offset, ...

    def schema(self, name: str, data: bytes) -> int:
        """Declare a JSON schema; returns its number."""
        record = Schema(id=len(self._schemas) + 1, data=data, encoding="jsonschema", name=name)
        self._schemas.append(record)
        self._add(packed(record))
        return record.id

    def channel(self, topic: str, schema: int, metadata: dict[str, str]) -> int:
        """Declare a channel of JSON objects; returns its number."""
        number = len(self._channels) + 1
        record = Channel(number, topic, "json", metadata, schema)
        self._channels.append(record)
        self._counts.append(0)
        self._add(packed(record))
        return number

    def message(self, channel: int, time: int, data: bytes) -> None:
        """Add a message, published and logged at `time`, ns."""
        entries = self._entries[channel]
        entries.append(time)
        entries.append(self._size)
        length = _LENGTH + len(data)
        sequence = self._counts[channel] + len(entries) // 2 - 1
        self._parts.append(_MESSAGE.pack(_OPCODE, length, channel, sequence & 0xFFFFFFFF, time, time))
        self._parts.append(data)
        self._size += 9 + length
        if self._size > _CHUNK:
            self._close_chunk()

    def metadata(self, name: str, data: dict[str, str]) -> None:
        """Add a metadata record, after the messages so far."""
        self._close_chunk()
        record = packed(Metadata(name=name, metadata=data))
        self._metadata.append(MetadataIndex(self._place, len(record), name))
        self._put(record)

    def flush(self) -> None:
        """Close the present chunk and hand everything to the system."""
        self._close_chunk()
        self._file.flush()

    def finish(self) -> None:
        """Write the index; nothing can be added afterwards."""
        self._close_chunk()
        self._put(packed(DataEnd(0)))
        start = self._place
        summary = packed(*self._schemas, *self._channels, self._statistics(), *self._chunks, *self._metadata)
        head = struct.pack("<BQQQ", Opcode.FOOTER, 8 + 8 + 4, start, 0)
        self._put(summary + packed(Footer(start, 0, zlib.crc32(head, zlib.crc32(summary)))) + MCAP0_MAGIC)
        self._file.close()

    def _add(self, record: bytes) -> None:
        self._parts.append(record)
        self._size += len(record)

    def _put(self, data: bytes) -> None:
        self._file.write(data)
        self._place += len(data)

    def _close_chunk(self) -> None:
        if not self._parts:
            return
        data = b"".join(self._parts)
        times = [time for entries in self._entries.values() for time in entries[::2]] or [0]
        compressed = zstandard.compress(data, _LEVEL)
        record = packed(Chunk("zstd", compressed, max(times), min(times), zlib.crc32(data), len(data)))
        chunk = self._place
        self._put(record)
        offsets, index = self._message_index()
        self._chunks.append(
            ChunkIndex(
                chunk_length=len(record),
                chunk_start_offset=chunk,
                compression="zstd",
                compressed_size=len(compressed),
                message_end_time=max(times),
                message_index_length=len(index),
                message_index_offsets=offsets,
                message_start_time=min(times),
                uncompressed_size=len(data),
            )
        )
        self._put(index)
        for channel, entries in self._entries.items():
            self._counts[channel] += len(entries) // 2
        self._clear()

    def _message_index(self) -> tuple[dict[int, int], bytes]:
        """Where the index of each channel of this chunk will stand, and all of them."""
        offsets, index = {}, b""
        for channel, entries in self._entries.items():
            offsets[channel] = self._place + len(index)
            size = 8 * len(entries)
            index += _INDEX.pack(Opcode.MESSAGE_INDEX, 6 + size, channel, size)
            index += struct.pack(f"<{len(entries)}Q", *entries)
        return offsets, index

    def _statistics(self) -> Statistics:
        filled = [chunk for chunk in self._chunks if chunk.message_index_offsets]
        return Statistics(
            attachment_count=0,
            channel_count=len(self._channels),
            channel_message_counts={channel: count for channel, count in enumerate(self._counts) if count},
            chunk_count=len(self._chunks),
            message_count=sum(self._counts),
            message_end_time=max((chunk.message_end_time for chunk in filled), default=0),
            message_start_time=min((chunk.message_start_time for chunk in filled), default=0),
            metadata_count=len(self._metadata),
            schema_count=len(self._schemas),
        )


def packed(*records: McapRecord) -> bytes:
    """Records as they stand in a file."""
    builder: Any = RecordBuilder()
    for record in records:
        record.write(builder)
    return bytes(builder.end())
