"""An MCAP file that is being written: the records are the `mcap` library's, the messages packed at once.

A message costs an eighth of the processor time that the library's own writer takes, a field at a time
(0.4 µs beside 3.3, `python -m tests.benchmarks.libraries`): a recorder shares two processors with a fleet.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping, Sequence
from io import BytesIO, FileIO
from pathlib import Path
from typing import Any

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

from deploy.telemetry.recording.mcap.chunk import Chunk, Times
from deploy.telemetry.recording.mcap.spare import Spare

_CHUNK = 256 * 1024  # bytes before compression; what one damaged place in the file can cost
_LEVEL = 1  # of compression, the fastest: for messages so much alike as small as the default
_CHANNELS = 1 << 16  # more cannot be numbered
_ROOM = 1 << 16  # bytes kept for the last metadata, besides those for the index


class McapFile:
    """Messages in chunks compressed with zstd, each chunk and kind of record indexed at the end.

    Raises:
        OSError: (all methods) the file cannot be written. What was written before is left whole, and there is
            room for `abandon` and `finish`.

    Attributes:
        size: bytes written.
    """

    def __init__(self, path: Path, library: str, profile: str = "") -> None:
        self._file: FileIO = path.open("wb", buffering=0)
        self._spare = Spare(path)
        self._index = 0  # bytes that the index will take
        self.size = 0
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._chunks: list[ChunkIndex] = []
        self._metadata: list[MetadataIndex] = []
        self._counts = np.zeros(_CHANNELS, np.int64)  # messages by channel, in closed chunks
        self._compressor = zstandard.ZstdCompressor(_LEVEL)
        self._chunk = Chunk()
        self._records = BytesIO()  # of a chunk; the same memory for all, for to get it costs most
        self._put(MCAP0_MAGIC + packed(Header(profile, library)))
        self._spare.hold(_ROOM)

    def schema(self, name: str, data: bytes, encoding: str = "jsonschema") -> int:
        """Declare a schema; returns its number."""
        record = Schema(id=len(self._schemas) + 1, data=data, encoding=encoding, name=name)
        self._schemas.append(record)
        self._declare(packed(record))
        return record.id

    def channel(self, topic: str, schema: int, metadata: dict[str, str], encoding: str = "json") -> int:
        """Declare a channel, of JSON objects unless told otherwise; returns its number."""
        number = len(self._channels) + 1
        record = Channel(number, topic, encoding, metadata, schema)
        self._channels.append(record)
        self._declare(packed(record))
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
        self._put(record)
        self._metadata.append(MetadataIndex(self.size - len(record), len(record), name))

    def flush(self) -> None:
        """Close the present chunk and hand everything to the system."""
        self._close_chunk()

    def abandon(self) -> None:
        """Drop the present chunk."""
        self._chunk = Chunk()

    def finish(self, metadata: Mapping[str, dict[str, str]]) -> None:
        """Write some last metadata and the index; nothing can be added afterwards."""
        self._close_chunk()
        self._spare.release()
        for name, data in metadata.items():
            self.metadata(name, data)
        end = packed(DataEnd(0))
        start = self.size + len(end)
        summary = packed(*self._schemas, *self._channels, self._statistics(), *self._chunks, *self._metadata)
        head = struct.pack("<BQQQ", Opcode.FOOTER, 8 + 8 + 4, start, 0)
        self._put(
            end + summary + packed(Footer(start, 0, zlib.crc32(head, zlib.crc32(summary)))) + MCAP0_MAGIC
        )
        self._file.close()

    def _put(self, data: bytes) -> None:
        """Write whole records, or none of them."""
        rest = memoryview(data)
        try:
            while rest:
                rest = rest[self._file.write(rest) :]
        except OSError:
            self._file.truncate(self.size)
            self._file.seek(self.size)
            raise
        self.size += len(data)

    def _declare(self, record: bytes) -> None:
        self._chunk.declare(record)
        self._index += len(record)

    def _close_chunk(self) -> None:
        if not self._chunk.size:
            return
        chunk, self._chunk = self._chunk, Chunk()
        self._records.seek(0)
        counts = self._counts.copy()
        contents = chunk.write(self._records, counts)
        with self._records.getbuffer()[: chunk.size] as records:
            data, checksum = self._compressor.compress(records), zlib.crc32(records)
        written = packed(ChunkRecord("zstd", data, contents.end, contents.start, checksum, chunk.size))
        indexes = b"".join(contents.indexes.values())
        index = ChunkIndex(
            chunk_length=len(written),
            chunk_start_offset=self.size,
            compression="zstd",
            compressed_size=len(data),
            message_end_time=contents.end,
            message_index_length=len(indexes),
            message_index_offsets=_offsets(contents.indexes, self.size + len(written)),
            message_start_time=contents.start,
            uncompressed_size=chunk.size,
        )
        self._index += len(packed(index))
        self._spare.hold(self._index + _ROOM)
        self._put(written + indexes)
        self._chunks.append(index)
        self._counts = counts

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


def _offsets(indexes: Mapping[int, bytes], place: int) -> dict[int, int]:
    """Where each channel's index stands, if the first stands at `place`."""
    offsets = {}
    for channel, index in indexes.items():
        offsets[channel] = place
        place += len(index)
    return offsets


def packed(*records: McapRecord) -> bytes:
    """Records as they stand in a file."""
    builder: Any = RecordBuilder()
    for record in records:
        record.write(builder)
    return bytes(builder.end())
