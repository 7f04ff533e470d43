"""What an MCAP file holds, whole or cut, and the files that follow it, read as one."""

from __future__ import annotations

import os
import struct
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from heapq import heappop, heappush
from io import BytesIO
from itertools import accumulate, count
from pathlib import Path
from typing import BinaryIO, NamedTuple

import zstandard
from mcap.exceptions import EndOfFile, McapError
from mcap.opcode import Opcode
from mcap.records import Channel, McapRecord, Message, Metadata
from mcap.stream_reader import StreamReader
from mcap.writer import MCAP0_MAGIC

from protocol.errors import RecordingError, UsageError

_HEAD = struct.Struct("<BQ")  # what every record begins with: opcode and length
_FIRST = struct.Struct("<Q")  # what a chunk begins with: its smallest log time
_DAMAGE = (
    McapError, ValueError, RuntimeError, OverflowError, struct.error, zstandard.ZstdError, MemoryError,
)  # fmt: skip
_NEVER = 1 << 64


class _Chunk(NamedTuple):
    start: int  # in the file
    end: int
    first: int  # smallest log time, ns


@dataclass
class Contents:
    """An MCAP file whose messages are in chunks, as in all that `McapFile` writes.

    Attributes:
        topics: by channel, of the chunks that were read so far; keys of the run, no pictures of it.
        cut: the file has no proper end, or a chunk that was read is damaged: all before that is here.
    """

    path: Path
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    topics: dict[int, str] = field(default_factory=dict)
    cut: bool = True
    _chunks: list[_Chunk] = field(default_factory=list)

    def messages(self, progress: Callable[[float], None] | None = None) -> Iterator[Message]:
        """In the order of their log time, within one time as they were written.

        A message is held back until no later chunk can have an earlier one.
        """
        waiting: list[tuple[int, int, Message]] = []
        order = count()
        for chunk, later, found in self._read():
            for record in found:
                if isinstance(record, Channel):
                    if not record.topic.startswith("/"):
                        self.topics[record.id] = record.topic
                elif isinstance(record, Message) and record.channel_id in self.topics:
                    heappush(waiting, (record.log_time, next(order), record))
            while waiting and waiting[0][0] <= later:
                yield heappop(waiting)[2]
            if progress is not None:
                progress(chunk.end / self._chunks[-1].end)
        while waiting:  # what follows is damaged
            yield heappop(waiting)[2]

    def _read(self) -> Iterator[tuple[_Chunk, int, list[McapRecord]]]:
        """Each chunk up to a damaged one, with the smallest log time of all after it, and its records."""
        starts = [chunk.first for chunk in self._chunks]
        laters = [*accumulate(reversed(starts), min, initial=_NEVER)][-2::-1]
        with self.path.open("rb") as file:
            for chunk, later in list(zip(self._chunks, laters, strict=True)):
                try:
                    yield chunk, later, _parsed(file, chunk.start, chunk.end)
                except _DAMAGE:
                    self.cut, self._chunks = True, self._chunks[: self._chunks.index(chunk)]
                    return


def contents(path: Path) -> Contents:
    """Look through an MCAP file, whole or cut, without reading its messages.

    Raises:
        UsageError: it cannot be opened.
        RecordingError: it is not an MCAP file.
    """
    found = Contents(path)
    try:
        with path.open("rb") as file:
            if file.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
                raise RecordingError(
                    f"{path} is not a recording: name a file that `disknav run --record` wrote"
                )
            for opcode, start, end in records(file):
                if opcode == Opcode.FOOTER:
                    file.seek(end)
                    found.cut = file.read() != MCAP0_MAGIC
                elif opcode == Opcode.CHUNK:
                    (first,) = _FIRST.unpack(_bytes(file, start + _HEAD.size, _FIRST.size))
                    found._chunks.append(_Chunk(start, end, first))
                elif opcode == Opcode.METADATA:
                    (record,) = _parsed(file, start, end)
                    assert isinstance(record, Metadata)
                    found.metadata[record.name] = record.metadata
    except OSError as error:
        raise UsageError(f"cannot read {path}: {error.strerror}") from error
    except _DAMAGE:
        found.cut = True
    return found


def records(file: BinaryIO) -> Iterator[tuple[int, int, int]]:
    """Opcode, start and end of every record that is complete, the footer at most."""
    size = file.seek(0, os.SEEK_END)
    place = len(MCAP0_MAGIC)
    opcode = 0
    while opcode != Opcode.FOOTER and place + _HEAD.size <= size:
        opcode, length = _HEAD.unpack(_bytes(file, place, _HEAD.size))
        end = place + _HEAD.size + length
        if end > size:
            return
        yield opcode, place, end
        place = end


def _parsed(file: BinaryIO, start: int, end: int) -> list[McapRecord]:
    """A record, or those of a chunk."""
    found: list[McapRecord] = []
    with suppress(EndOfFile):  # there is nothing else
        found.extend(
            StreamReader(BytesIO(_bytes(file, start, end - start)), True, validate_crcs=True).records
        )
    return found


def _bytes(file: BinaryIO, start: int, size: int) -> bytes:
    file.seek(start)
    return file.read(size)


class Series:
    """As `Contents`, of a file and all that follow it.

    Attributes:
        path: of the first.
        metadata: of the first what the run is, of the last how it ended.
        topics: by channel, of what was read so far; a topic has one number in all files.
        cut: one has no proper end or is damaged, or the next is not there.
    """

    def __init__(self, parts: list[Contents], complete: bool) -> None:
        self.path, self._parts, self._complete = parts[0].path, parts, complete
        self.topics: dict[int, str] = {}
        first, self.metadata = parts[0].metadata, dict(parts[-1].metadata)
        self.metadata.update({name: first[name] for name in ("run", "scenario") if name in first})
        self._numbers: dict[str, int] = {}

    @property
    def cut(self) -> bool:
        """See above."""
        return not self._complete or any(part.cut for part in self._parts)

    def messages(self, progress: Callable[[float], None] | None = None) -> Iterator[Message]:
        """File after file; see `Contents.messages`."""
        for done, part in enumerate(self._parts):

            def tell(share: float, done: int = done) -> None:
                if progress is not None:
                    progress((done + share) / len(self._parts))

            for message in part.messages(tell):
                topic = part.topics[message.channel_id]
                message.channel_id = self._numbers.setdefault(topic, len(self._numbers) + 1)
                self.topics[message.channel_id] = topic
                yield message


def _run(part: Contents) -> str:
    return part.metadata.get("run", {}).get("name", "")


def series(path: Path) -> Contents | Series:
    """Look through a file and those that follow it.

    Raises:
        UsageError, RecordingError: as `contents`, of the first.
    """
    parts, complete = [contents(path)], True
    seen = {path}
    while following := parts[-1].metadata.get("recorder", {}).get("following"):
        path = path.with_name(Path(following).name)
        try:
            part = contents(path)
        except (UsageError, RecordingError):
            complete = False
            break
        if path in seen or _run(part) != _run(parts[0]):
            complete = False  # another recording has taken the name
            break
        seen.add(path)
        parts.append(part)
    return parts[0] if complete and len(parts) == 1 else Series(parts, complete)
