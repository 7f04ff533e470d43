"""An MCAP file that is being written: the records are the `mcap` library's, the messages packed at once.

A message costs an eighth of the processor time that the library's own writer takes, a field at a time
(0.4 µs beside 3.3, `python -m tests.benchmarks.libraries`): a recorder shares two processors with a fleet.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
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
from mcap.records import Chunk as ChunkRecord
from mcap.writer import MCAP0_MAGIC

from deploy.recording.mcap.chunk import Chunk, Times

_CHUNK = 256 * 1024  # bytes before compression; what one damaged place in the file can cost
_LEVEL = 1  # of compression, the fastest: for messages so much alike as small as the default
_CHANNELS = 1 << 16  # more cannot be numbered


class McapFile:
    """Messages in chunks compressed with zstd, each chunk and kind of record indexed at the end.

    Raises:
        OSError: (all methods) the file cannot be written.
    """

    def __init__(self, path: Path, library: str, profile: str = "") -> None:
        self._file: BinaryIO = path.open("wb")
        self._place = 0
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._chunks: list[ChunkIndex] = []
        self._metadata: list[MetadataIndex] = []
        self._counts = np.zeros(_CHANNELS, np.int64)  # messages by channel, in closed chunks
        self._compressor = zstandard.ZstdCompressor(_LEVEL)
        self._chunk = Chunk()
        self._records = BytesIO()  # of a chunk; the same memory for all, for to get it costs most
        self._put(MCAP0_MAGIC + packed(Header(profile, library)))

    def schema(self, name: str, data: bytes, encoding: str = "jsonschema") -> int:
        """Declare a schema; returns its number."""
        record = Schema(id=len(self._schemas) + 1, data=data, encoding=encoding, name=name)
        self._schemas.append(record)
        self._chunk.declare(packed(record))
        return record.id

    def channel(self, topic: str, schema: int, metadata: dict[str, str], encoding: str = "json") -> int:
        """Declare a channel, of JSON objects unless told otherwise; returns its number."""
        number = len(self._channels) + 1
        record = Channel(number, topic, encoding, metadata, schema)
        self._channels.append(record)
        self._chunk.declare(packed(record))
        return number

    def messages(self, channels: Sequence[int], times: Times, lines: bytes) -> None:
        """See `Chunk.add`."""
        self._chunk.add(channels, times, lines)
        if self._chunk.size > _CHUNK:
            self._close_chunk()

    def message(self, channel: int, time: int, data: bytes) -> None:
        """See `Chunk.put`."""
        self._chunk.put(channel, time, data)
        if self._chunk.size > _CHUNK:
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

    def _put(self, data: bytes) -> None:
        self._file.write(data)
        self._place += len(data)

    def _close_chunk(self) -> None:
        if not self._chunk.size:
            return
        chunk, self._chunk = self._chunk, Chunk()
        self._records.seek(0)
        contents = chunk.write(self._records, self._counts)
        with self._records.getbuffer()[: chunk.size] as records:
            data, checksum = self._compressor.compress(records), zlib.crc32(records)
        place = self._place
        self._put(packed(ChunkRecord("zstd", data, contents.end, contents.start, checksum, chunk.size)))
        length = self._place - place
        offsets = self._put_indexes(contents.indexes)
        self._chunks.append(
            ChunkIndex(
                chunk_length=length,
                chunk_start_offset=place,
                compression="zstd",
                compressed_size=len(data),
                message_end_time=contents.end,
                message_index_length=self._place - place - length,
                message_index_offsets=offsets,
                message_start_time=contents.start,
                uncompressed_size=chunk.size,
            )
        )

    def _put_indexes(self, indexes: Mapping[int, bytes]) -> dict[int, int]:
        """Add the message indexes; returns where each channel's stands."""
        offsets = {}
        for channel, index in indexes.items():
            offsets[channel] = self._place
            self._put(index)
        return offsets

    def _statistics(self) -> Statistics:
        filled = [chunk for chunk in self._chunks if chunk.message_index_offsets]
        return Statistics(
            attachment_count=0,
            channel_count=len(self._channels),
            channel_message_counts={
                number: int(self._counts[number]) for number in np.flatnonzero(self._counts).tolist()
            },
            chunk_count=len(self._chunks),
            message_count=int(self._counts.sum()),
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
